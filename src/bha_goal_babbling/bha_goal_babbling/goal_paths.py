"""Straight paths: from goal to goal in the space of outcomes, or home in the space of actions."""

import math

import numpy as np
from numpy.typing import ArrayLike

from bha_goal_babbling.arrays import FloatArray, matrix
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_choice import RandomGoalChoice
from bha_goal_babbling.saved_state import SavedState


def straight_line(start: FloatArray, end: FloatArray, steps: int) -> FloatArray:
    """Return evenly spaced points from start (left out) to end (exactly met).

    Parameters
    ----------
    start, end : array
        Points in any unit, shape (n,).
    steps : int
        Number of points, at least 1.

    Returns
    -------
    array
        Shape (steps, n).
    """
    if steps < 1:
        raise InvalidConfigError(f"a path needs at least 1 step, got {steps}")
    share = np.arange(1, steps + 1)[:, np.newaxis] / steps
    line = start + share * (end - start)
    line[-1] = end
    return line


class GoalPaths:
    """Targets along straight lines between goals drawn at random from a finite set.

    Parameters
    ----------
    goals : array_like
        The goal set, in the unit of outcomes, shape (G, n) with G >= 2.
    steps : int
        Number L of steps of a movement.
    """

    kind = "goal_paths"

    def __init__(self, goals: ArrayLike, steps: int) -> None:
        self._goals = matrix("goals", goals)
        self._choice = RandomGoalChoice(len(self._goals))
        if steps < 1:
            raise InvalidConfigError(f"a movement needs at least 1 step, got {steps}")
        self._steps = steps
        self._path = np.empty((0, self.size))
        self._next = 0

    @property
    def size(self) -> int:
        """Number n of coordinates of a target."""
        return int(self._goals.shape[1])

    @property
    def goals(self) -> FloatArray:
        """The goal set, shape (G, n), a copy."""
        return self._goals.copy()

    def begin(
        self, target: FloatArray, outcome: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Start a line from the last target to a goal; see `TargetSource`."""
        goal = self._goals[self._choice.choose(rng)]
        self._path = straight_line(target, goal, self._steps)
        self._next = 0
        return target

    def target(self) -> FloatArray:
        """Return the target of the present step, shape (n,)."""
        point: FloatArray = self._path[self._next]
        return point

    @property
    def goal_error(self) -> float:
        """Infinite: no account is kept of errors."""
        return math.inf

    def advance(self, outcome_step: FloatArray, outcome: FloatArray | None = None) -> bool:
        """Go on to the next step and return whether the goal was the last."""
        self._next += 1
        return self._next == len(self._path)

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {"goals": self._goals.copy(), "path": self._path.copy()}
        settings = {"steps": self._steps, "next": self._next, "last_goal": self._choice.last}
        return SavedState(arrays, settings)

    @classmethod
    def restore(cls, state: SavedState) -> "GoalPaths":
        """Return the source whose snapshot this is."""
        paths = cls(state.arrays["goals"], int(state.settings["steps"]))
        paths._path = matrix_or_empty(state.arrays["path"], paths.size)
        paths._next = int(state.settings["next"])
        if not 0 <= paths._next <= len(paths._path):
            raise InvalidConfigError(f"path has {len(paths._path)} steps, next is {paths._next}")
        paths._choice = RandomGoalChoice(len(paths._goals), int(state.settings["last_goal"]))
        return paths


def matrix_or_empty(path: FloatArray, columns: int) -> FloatArray:
    """Return a copy of a path, shape (L, columns), that may have no step at all."""
    if path.shape == (0, columns):
        return path.copy()
    return matrix("path", path, columns)
