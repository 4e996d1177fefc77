"""Exploratory noise that is one and the same smooth function for nearby targets.

    E_t(x*) = A_t x* + c_t

Every entry e of A_t and c_t walks at random and is drawn back so that its spread stays s:
e <- sqrt(s^2 / (s^2 + sd^2)) (e + N(0, sd^2)) (Rolf, Steil and Gienger, 2011).
"""

import math

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState


class ExplorationNoise:
    """A random linear function of the target that changes a little at every step.

    Parameters
    ----------
    spread : float
        Standard deviation s of every entry, in the unit of actions; 0 for no noise.
    step : float
        Standard deviation sd of the walk's step, in the unit of actions (absolute, not a share
        of s). sd much below s is slow noise, sd = s or above nearly fresh noise at every step.
    action_size, outcome_size : int
        Numbers m and n of coordinates.
    rng : numpy.random.Generator
        Source of the first entries.
    """

    def __init__(
        self,
        spread: float,
        step: float,
        action_size: int,
        outcome_size: int,
        rng: np.random.Generator,
    ) -> None:
        if not (spread >= 0 and step >= 0):
            raise InvalidConfigError(f"spread and step must not be negative, got {spread}, {step}")
        self._step = float(step)
        self.keep = spread / math.hypot(spread, step) if spread > 0 else 0.0
        """Share of an entry that a step of the walk keeps [-]."""
        # Row 0 is c_t, rows 1 to n are the columns of A_t.
        self._entries = spread * rng.standard_normal((1 + outcome_size, action_size))

    def advance(self, rng: np.random.Generator) -> None:
        """Take one step of the walk."""
        self._entries += self._step * rng.standard_normal(self._entries.shape)
        self._entries *= self.keep

    def at(self, target: FloatArray) -> FloatArray:
        """Return E_t at a target, shape (n,), in the unit of actions, shape (m,)."""
        noise: FloatArray = self._entries[0] + target @ self._entries[1:]
        return noise

    def state(self) -> SavedState:
        """Return what `load` needs."""
        return SavedState({"entries": self._entries.copy()})

    def load(self, state: SavedState) -> None:
        """Take over the entries of a snapshot of noise of the same size."""
        entries = state.arrays["entries"]
        if entries.shape != self._entries.shape:
            raise InvalidConfigError(
                f"noise has shape {entries.shape}, expected {self._entries.shape}"
            )
        self._entries = entries.copy()
