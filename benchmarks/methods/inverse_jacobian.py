"""Inverse Jacobian control: steps of the action that bring a wished step of the outcome.

    dq = J^+ dx + (I - J^+ J) dq_0,   J^+ = J' (J J' + damping^2 I)^-1

The first part is the shortest action step, the second pulls wherever that leaves the outcome alone
(Liegeois, "Automatic supervisory control of the configuration and behavior of multibody
mechanisms", 1977). Damping keeps steps finite near singular postures.
"""

from collections.abc import Callable

import numpy as np

from bha_goal_babbling.arrays import FloatArray


def damped_inverse(jacobians: FloatArray, damping: float) -> FloatArray:
    """Return J^+ of Jacobians, shape (N, n, m), as shape (N, m, n); damping in their unit."""
    square = jacobians @ jacobians.transpose(0, 2, 1)
    square += damping**2 * np.eye(jacobians.shape[1])
    return np.linalg.solve(square, jacobians).transpose(0, 2, 1)


def resolved_step(
    jacobians: FloatArray, outcome_steps: FloatArray, pull: FloatArray, damping: float
) -> FloatArray:
    """Return dq.

    Parameters
    ----------
    jacobians : array
        J, shape (N, n, m).
    outcome_steps : array
        dx, shape (N, n).
    pull : array
        dq_0, shape (N, m).
    damping : float
        In the unit of the Jacobian.

    Returns
    -------
    array
        Shape (N, m).
    """
    inverses = damped_inverse(jacobians, damping)
    rest = outcome_steps - np.einsum("anm,am->an", jacobians, pull)
    return pull + np.einsum("amn,an->am", inverses, rest)


def follow_lines(
    predict: Callable[[FloatArray], FloatArray],
    jacobian: Callable[[FloatArray], FloatArray],
    clipped: Callable[[FloatArray], FloatArray],
    home_action: FloatArray,
    goals: FloatArray,
    *,
    steps: int = 8,
    home_pull: float = 0.0,
    damping: float = 0.05,
) -> FloatArray:
    """Search the actions for goals on a forward model, along straight lines from home.

    Parameters
    ----------
    predict, jacobian : callable
        The model: actions, shape (N, m), to outcomes (N, n), and to Jacobians (N, n, m).
    clipped : callable
        Puts actions into their limits.
    home_action : array
        Where the search starts, shape (m,).
    goals : array
        Shape (N, n).
    steps : int
        Steps on the line; as many follow at the goal, where they correct what is left.
    home_pull : float
        Share of the way home that each step pulls in the null space (Jamone et al., 2011).
    damping : float
        In the unit of the Jacobian.

    Returns
    -------
    array
        Shape (N, m).
    """
    actions = np.tile(home_action, (len(goals), 1))
    start = predict(actions[:1])
    for share in np.minimum(np.arange(1, 2 * steps + 1) / steps, 1.0):
        wanted = start + share * (goals - start)
        pull = home_pull * (home_action - actions)
        step = resolved_step(jacobian(actions), wanted - predict(actions), pull, damping)
        actions = clipped(actions + step)
    return actions
