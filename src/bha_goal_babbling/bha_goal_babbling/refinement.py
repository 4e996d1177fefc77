"""The last step from an action to one that brings an outcome: Newton's, with damping and ends."""

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.forward_model import ForwardModel

_ITERATIONS = 3
_DAMPING = 0.1
"""Slope below which a direction counts as one in which actions move nothing, in scaled units."""
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
    dq = J' (J J' + damping^2 I)^-1 (x* - f(q)). An entry that would leave its range is held at the
    end, and the others make up for it.

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
        Largest distance of the answer from the action (once it is within the range), in the unit
        of actions: farther away the model has seen nothing.
    """
    start = np.minimum(np.maximum(action, low), high)
    refined = start
    for _ in range(_ITERATIONS):
        missed = goal - model.predict(refined)
        length = np.linalg.norm(missed)
        if length > _TRUSTED:
            missed = missed * (_TRUSTED / length)
        refined = _step(refined, missed, model.jacobian(refined), low, high)
    away = refined - start
    distance = float(np.linalg.norm(away))
    return refined if distance <= reach else start + away * (reach / distance)


def _step(
    action: FloatArray, missed: FloatArray, jacobian: FloatArray, low: FloatArray, high: FloatArray
) -> FloatArray:
    """Take one step, in as many rounds as entries come to an end of their range."""
    free = np.ones(action.size, dtype=bool)
    damping = _DAMPING**2 * np.eye(missed.size)
    while free.any():
        moving = jacobian * free
        wanted = action + moving.T @ np.linalg.solve(moving @ moving.T + damping, missed)
        out = free & ((wanted < low) | (wanted > high))
        if not out.any():
            return wanted
        held = np.where(out, np.minimum(np.maximum(wanted, low), high), action)
        missed = missed - jacobian @ (held - action)
        action, free = held, free & ~out
    return action
