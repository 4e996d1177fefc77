"""Which goal comes next: one of a finite set, never the same twice running."""

import math

import numpy as np

from bha_goal_babbling.arrays import FloatArray
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

    def report(self, goal: int, error: float) -> None:
        """Pass over the error with which a goal was reached: it makes no difference to chance."""

    def last_error(self, goal: int) -> float:
        """Return inf: no account is kept of errors."""
        return math.inf


class LargestErrorChoice:
    """Draws a few goals at random, and of these takes the one with the largest last error.

    What goes wrong is exercised more often, yet every goal comes again and again: a goal whose
    error cannot be helped takes up a part of the movements and no more.

    Parameters
    ----------
    candidates : int
        Number of goals drawn; with 1 this is `RandomGoalChoice`.
    last : int
        Index that must not come first, -1 for none.
    """

    def __init__(self, candidates: int, last: int = -1) -> None:
        if candidates < 1:
            raise InvalidConfigError(f"at least 1 goal must be drawn, got {candidates}")
        self._candidates = candidates
        self.last = last

    def choose(self, errors: FloatArray, rng: np.random.Generator) -> int:
        """Return the index of the next goal, given the last errors of all goals, shape (G,)."""
        drawn = [
            RandomGoalChoice(len(errors), self.last).choose(rng) for _ in range(self._candidates)
        ]
        self.last = max(drawn, key=lambda goal: float(errors[goal]))
        return self.last
