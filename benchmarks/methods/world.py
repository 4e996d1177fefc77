"""What every compared method acts on: a robot that counts what it is asked to do."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from benchmarks.arm.reaching import ReachingTask
from bha_goal_babbling.arrays import FloatArray, matrix, vector


class World:
    """A robot to explore, its home, its limits and the goals it is to reach.

    The world counts samples and travel itself, so that every method pays for what it executes.

    Parameters
    ----------
    forward : callable
        Outcome of one action, shape (m,) to shape (n,).
    home_action : array_like
        Where all learning starts, shape (m,) [action unit].
    action_low, action_high : array_like
        Limits, shape (m,) [action unit].
    goals : array_like
        Goal set, shape (G, n) [outcome unit].
    """

    def __init__(
        self,
        forward: Callable[[FloatArray], FloatArray],
        home_action: ArrayLike,
        action_low: ArrayLike,
        action_high: ArrayLike,
        goals: ArrayLike,
    ) -> None:
        self._forward = forward
        self.home_action = vector("home_action", home_action)
        self.action_low = vector("action_low", action_low, self.home_action.size)
        self.action_high = vector("action_high", action_high, self.home_action.size)
        self.home_outcome = vector("home_outcome", forward(self.home_action))
        self.goals = matrix("goals", goals, self.home_outcome.size)
        self.samples = 0
        self.travel = 0.0
        self._last_action = self.home_action

    @classmethod
    def of_task(cls, task: ReachingTask) -> "World":
        """Return the world in which the reaching task of the tables is learned."""
        return cls(task.arm.forward, task.home_action, -task.limits, task.limits, task.goals)

    def clipped(self, actions: FloatArray) -> FloatArray:
        """Return actions, shape (..., m), within the limits."""
        return np.minimum(np.maximum(actions, self.action_low), self.action_high)

    def execute(self, action: FloatArray) -> FloatArray:
        """Execute one action, shape (m,), and return its outcome, shape (n,).

        The action must be within the limits, or what a method learned would not be what was done.
        """
        if not np.array_equal(action, self.clipped(action)):
            raise ValueError(f"the action exceeds the limits: {action.tolist()}")
        self.samples += 1
        self.travel += float(np.linalg.norm(action - self._last_action))
        self._last_action = action.copy()
        return self._forward(action)

    def error(self, actions: FloatArray) -> float:
        """Return the mean distance to the goals of the outcomes of actions, shape (G, m).

        For measurement only: nothing is counted.
        """
        outcomes = np.array([self._forward(action) for action in self.clipped(actions)])
        return float(np.linalg.norm(outcomes - self.goals, axis=1).mean())
