"""Straight lines cut into steps, and a walk along one of them."""

from typing import Any

import numpy as np

from bha_goal_babbling.arrays import FloatArray, matrix_or_empty
from bha_goal_babbling.errors import InvalidConfigError
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


class StraightWalk:
    """The steps of one movement to a goal after the other; before the first there are none.

    Parameters
    ----------
    size : int
        Number n of coordinates of a point.
    steps : int
        Number L of steps from one goal to the next, at least 1.
    """

    def __init__(self, size: int, steps: int) -> None:
        if steps < 1:
            raise InvalidConfigError(f"a movement needs at least 1 step, got {steps}")
        self._steps = steps
        self._path = np.empty((0, size))
        self._next = 0

    def begin(self, start: FloatArray, goal: FloatArray, stay: int = 0) -> None:
        """Walk from a point to a goal, shapes (n,), which stays the target for some more steps."""
        line = straight_line(start, goal, self._steps)
        self._path = np.vstack([line, np.tile(line[-1], (stay, 1))])
        self._next = 0

    @property
    def stays(self) -> bool:
        """Whether the present step is one for which the goal stays the target."""
        return self._next >= self._steps

    @property
    def target(self) -> FloatArray:
        """Point of the present step, shape (n,)."""
        point: FloatArray = self._path[self._next]
        return point

    @property
    def goal(self) -> FloatArray:
        """Last point of the walk, shape (n,)."""
        point: FloatArray = self._path[-1]
        return point

    def advance(self) -> bool:
        """Go on to the next step and return whether the last one is over."""
        self._next += 1
        return self._next == len(self._path)

    def saved_in(
        self, arrays: dict[str, FloatArray], settings: dict[str, Any] | None = None
    ) -> SavedState:
        """Return the snapshot of what walks: its own arrays and settings and, in them, the walk."""
        return SavedState(
            {**arrays, "path": self._path.copy()},
            {**(settings or {}), "steps": self._steps, "next": self._next},
        )

    @classmethod
    def restored_from(cls, state: SavedState, size: int) -> "StraightWalk":
        """Return the walk that `saved_in` has put into a snapshot."""
        walk = cls(size, int(state.settings["steps"]))
        walk._path = matrix_or_empty("path", state.arrays["path"], size)
        walk._next = int(state.settings["next"])
        if not 0 <= walk._next <= len(walk._path):
            raise InvalidConfigError(f"path has {len(walk._path)} steps, next is {walk._next}")
        return walk
