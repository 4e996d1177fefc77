"""The last step from an action to one that brings an outcome: Newton's, with damping and ends."""

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.forward_model import ForwardModel

_ITERATIONS, _FAR_ITERATIONS = 3, 10
"""Steps for a small miss, and before that for a large one, such as an end brings that has moved."""
_DAMPING = 0.1
"""Slope below which a direction counts as one in which actions move nothing, in scaled units."""
_ROUNDS, _BLOCK_ROUNDS = 200, 10
"""Rounds of pivoting at most, and those in which entries change together; 2 to 4 are the rule."""
_SLACK = 1e-12
"""What counts as rounding, in scaled units."""
_TRUSTED = 0.2
"""Largest miss, in the unit of outcomes, that one iteration tries to make up for."""


def refined(
    action: FloatArray,
    goal: FloatArray,
    model: ForwardModel,
    low: FloatArray,
    high: FloatArray,
    reach: float,
    *,
    cautious: bool = False,
) -> FloatArray:
    """Return the action near a given one whose predicted outcome is the goal.

    The step is that of damped least squares (Nakamura and Hanafusa, 1986): the least of
    |x* - f(q) - J dq|^2 + damping^2 |dq|^2 among the actions within their range. Where an entry
    comes to an end, the others make up for it.

    The model is sure of what it says near what was explored, and only there. A cautious step counts
    that: what it makes least is the expected square of the miss, E |x* - x|^2 =
    |x* - f(q)|^2 + n v(q), v the variance of each of the n entries of f(q).

    Parameters
    ----------
    action : array
        Where to begin, shape (m,).
    goal : array
        The outcome x*, shape (n,).
    model : ForwardModel
        Predicts outcomes.
    low, high : array
        Ends of the range, shape (m,).
    reach : float
        Largest distance of the answer from the action once it is within the range, in the unit of
        actions: farther away the model has seen nothing. What the range takes from the action is
        added, since others have to make up for as much.
    cautious : bool
        Whether what the model does not know counts: not for exploration, which is to find it out.
    """
    start = np.minimum(np.maximum(action, low), high)
    refined = start
    near, far = _ITERATIONS, _FAR_ITERATIONS
    damping = _DAMPING**2 * np.eye(action.size)
    while near > 0 and far > 0:
        missed = goal - model.predict(refined)
        length = float(np.linalg.norm(missed))
        if length > _TRUSTED:
            share = _TRUSTED / length
            far -= 1
        else:
            share = 1.0
            near -= 1
        slope = model.jacobian(refined)
        pull = slope.T @ missed
        stiffness = slope.T @ slope + damping
        if cautious:
            rise, curvature = model.variance_near(refined)
            pull -= goal.size * rise
            stiffness += goal.size * curvature
        refined = refined + _step(stiffness, share * pull, low - refined, high - refined)
    away = refined - start
    distance = float(np.linalg.norm(away))
    reach = reach + float(np.linalg.norm(start - action))
    return refined if distance <= reach else start + away * (reach / distance)


def _step(stiffness: FloatArray, pull: FloatArray, low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the step s within its range, all of shape (m,), of least s' stiffness s - 2 s' pull.

    Which entries lie at an end is found by block principal pivoting (Portugal, Judice and Vicente,
    1994). The answer is the only one there is, so it moves but little when the goal does: an entry
    that is held too early and never let go makes answers jump to and fro.
    """
    at_low = np.zeros(pull.size, dtype=bool)
    at_high = np.zeros(pull.size, dtype=bool)
    for round_ in range(_ROUNDS):
        held = np.where(at_low, low, np.where(at_high, high, 0.0))
        free = ~(at_low | at_high)
        moving = np.where(np.outer(free, free), stiffness, np.eye(pull.size))
        step = held + np.linalg.solve(moving, np.where(free, pull - stiffness @ held, 0.0))
        left = pull - stiffness @ step
        flips_low = np.where(at_low, left > _SLACK, ~at_high & (step < low - _SLACK))
        flips_high = np.where(at_high, left < -_SLACK, ~at_low & (step > high + _SLACK))
        flips = flips_low | flips_high
        if not flips.any():
            break
        if round_ >= _BLOCK_ROUNDS:  # one entry a round comes to an end for certain (Murty, 1974)
            flips &= np.arange(flips.size) == flips.nonzero()[0][-1]
        at_low ^= flips_low & flips
        at_high ^= flips_high & flips
    answer: FloatArray = np.minimum(np.maximum(step, low), high)
    return answer
