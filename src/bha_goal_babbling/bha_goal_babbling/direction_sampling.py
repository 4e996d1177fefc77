"""Targets along random directions: explores a workspace whose size and shape nobody knows.

    x*_t = x*_{t-1} + eps * direction

The direction is kept as long as the outcome follows. When it moves against it, as it does at the
edge of what can be reached, a new direction is drawn and counted from what was observed (Rolf,
"Goal babbling with unknown ranges: a direction-sampling approach", 2013).
"""

import math

import numpy as np

from bha_goal_babbling.arrays import FloatArray, vector
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState


class DirectionTargets:
    """Targets that go straight on until the outcome is thrown back.

    Parameters
    ----------
    step : float
        Distance eps between successive targets, in the unit of outcomes.
    size : int
        Number n of coordinates of a target.
    """

    kind = "directions"

    def __init__(self, step: float, size: int) -> None:
        if not (step > 0 and size >= 1):
            raise InvalidConfigError(
                f"step must be above 0 and size at least 1, got {step} and {size}"
            )
        self.step = float(step)
        """Distance eps between successive targets [outcome unit]."""
        self._size = size
        self._advance = np.zeros(size)
        self._target = np.zeros(size)

    @property
    def size(self) -> int:
        """Number n of coordinates of a target."""
        return self._size

    def begin(
        self, target: FloatArray, outcome: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Draw a direction and start it at the last outcome; see `TargetSource`."""
        direction = rng.standard_normal(self._size)
        length = np.linalg.norm(direction)
        while length < 1e-9:  # A vector of zeros has no direction; it practically never comes.
            direction = rng.standard_normal(self._size)
            length = np.linalg.norm(direction)
        self._advance = self.step / length * direction
        self._target = outcome + self._advance
        return outcome

    def target(self) -> FloatArray:
        """Return the target of the present step, shape (n,)."""
        return self._target

    @property
    def goal_error(self) -> float:
        """Infinite: no account is kept of errors."""
        return math.inf

    @property
    def resting(self) -> bool:
        """Never: one movement follows the other."""
        return False

    def advance(self, outcome_step: FloatArray, outcome: FloatArray | None = None) -> bool:
        """Go on in the same direction and return whether the outcome moved against it."""
        if float(self._advance.dot(outcome_step)) < 0.0:
            return True
        self._target = self._target + self._advance
        return False

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {"advance": self._advance.copy(), "target": self._target.copy()}
        return SavedState(arrays, {"step": self.step, "size": self._size})

    @classmethod
    def restore(cls, state: SavedState) -> "DirectionTargets":
        """Return the source whose snapshot this is."""
        targets = cls(float(state.settings["step"]), int(state.settings["size"]))
        targets._advance = vector("advance", state.arrays["advance"], targets.size)
        targets._target = vector("target", state.arrays["target"], targets.size)
        return targets
