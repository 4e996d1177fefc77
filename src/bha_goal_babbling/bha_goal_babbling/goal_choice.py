"""Which goal comes next: one of a finite set, at random, never the same twice running."""

import numpy as np

from bha_goal_babbling.errors import InvalidConfigError


class RandomGoalChoice:
    """Draws indices of goals uniformly among all but the last.

    Parameters
    ----------
    count : int
        Number of goals, at least 2.
    last : int
        Index that must not come first, -1 for none.
    """

    def __init__(self, count: int, last: int = -1) -> None:
        if count < 2:
            raise InvalidConfigError(f"the goal set must hold at least 2 goals, got {count}")
        if not -1 <= last < count:
            raise InvalidConfigError(f"last must be -1 to {count - 1}, got {last}")
        self._count = count
        self.last = last

    def choose(self, rng: np.random.Generator) -> int:
        """Return the index of the next goal."""
        if self.last < 0:
            self.last = int(rng.integers(self._count))
        else:
            # One of the other goals: those behind the last one move up by one.
            index = int(rng.integers(self._count - 1))
            self.last = index if index < self.last else index + 1
        return self.last
