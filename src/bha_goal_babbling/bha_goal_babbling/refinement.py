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
) -> FloatArray:
    """Return the action near a given one whose predicted outcome is the goal.

    The step is that of damped least squares (Nakamura and Hanafusa, 1986),
    dq = J' (J J' + damping^2 I)^-1 (x* - f(q)), among the actions within their range: where an
    entry comes to an end, the others make up for it.

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
    """
    start = np.minimum(np.maximum(action, low), high)
    refined = start
    near, far = _ITERATIONS, _FAR_ITERATIONS
    while near > 0 and far > 0:
        missed = goal - model.predict(refined)
        length = np.linalg.norm(missed)
        if length > _TRUSTED:
            missed = missed * (_TRUSTED / length)
            far -= 1
        else:
            near -= 1
        refined = _step(refined, missed, model.jacobian(refined), low, high)
    away = refined - start
    distance = float(np.linalg.norm(away))
    reach = reach + float(np.linalg.norm(start - action))
    return refined if distance <= reach else start + away * (reach / distance)


def _step(
    action: FloatArray, missed: FloatArray, jacobian: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Take the step s of least |J s - missed|^2 + damping^2 |s|^2 within the range.

    Which entries lie at an end is found by block principal pivoting (Portugal, Judice and Vicente,
    1994). The answer is the only one there is, so it moves but little when the goal does: an entry
    that is held too early and never let go makes answers jump to and fro.
    """
    low, high = low - action, high - action
    at_low = np.zeros(action.size, dtype=bool)
    at_high = np.zeros(action.size, dtype=bool)
    damping = _DAMPING**2 * np.eye(missed.size)
    for round_ in range(_ROUNDS):
        held = np.where(at_low, low, np.where(at_high, high, 0.0))
        moving = jacobian * ~(at_low | at_high)
        rest = missed - jacobian @ held
        step = held + moving.T @ np.linalg.solve(moving @ moving.T + damping, rest)
        pull = jacobian.T @ (missed - jacobian @ step) - _DAMPING**2 * step
        flips_low = np.where(at_low, pull > _SLACK, ~at_high & (step < low - _SLACK))
        flips_high = np.where(at_high, pull < -_SLACK, ~at_low & (step > high + _SLACK))
        flips = flips_low | flips_high
        if not flips.any():
            break
        if round_ >= _BLOCK_ROUNDS:  # one entry a round comes to an end for certain (Murty, 1974)
            flips &= np.arange(flips.size) == flips.nonzero()[0][-1]
        at_low ^= flips_low & flips
        at_high ^= flips_high & flips
    answer: FloatArray = action + np.minimum(np.maximum(step, low), high)
    return answer
