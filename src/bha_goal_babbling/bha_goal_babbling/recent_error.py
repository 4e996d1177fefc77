"""How well it has gone lately: a running mean of distances."""

import math

import numpy as np

from bha_goal_babbling.saved_state import SavedState


class RecentError:
    """The plain mean of the first distances, then a running one.

    Parameters
    ----------
    window : int
        Number of distances that the mean looks back on, about.
    """

    def __init__(self, window: int) -> None:
        self._window = window
        self._count = 0
        self._mean = math.nan

    @property
    def value(self) -> float:
        """The mean, in the unit of the distances; NaN before the first."""
        return self._mean

    def add(self, distance: float) -> None:
        """Take one more distance."""
        self._count = min(self._count + 1, self._window)
        if self._count == 1:
            self._mean = distance
        else:
            self._mean += (distance - self._mean) / self._count

    def state(self) -> SavedState:
        """Return what `load` needs."""
        return SavedState({"mean": np.array([self._mean])}, {"count": self._count})

    def load(self, state: SavedState) -> None:
        """Take over the mean of a snapshot."""
        self._mean = float(state.arrays["mean"][0])
        self._count = int(state.settings["count"])
