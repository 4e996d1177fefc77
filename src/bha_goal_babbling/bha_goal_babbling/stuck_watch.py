"""Which entries of an action stay short of what is commanded, because they have come to an end.

What was commanded lately spans an interval. A reading within it followed; one that stays outside
of it, beyond a margin, is stuck.
"""

import numpy as np
from numpy.typing import NDArray

from bha_goal_babbling.arrays import FloatArray, matrix_or_empty
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState

BoolArray = NDArray[np.bool_]

_WINDOW = 4
"""Commands that a reading may still be following; lags of the robot are shorter."""
_STILL = 0.4
"""Largest step of a reading that is stuck, in margins: one that moves is still on its way."""


class StuckWatch:
    """Watches commands and what is read of them.

    Parameters
    ----------
    size : int
        Number m of entries of an action.
    margin : float
        How far a reading must lie outside of what was commanded, while it keeps still, to be
        stuck, in the unit of actions.
    """

    def __init__(self, size: int, margin: float) -> None:
        self._margin = margin
        self._commands = np.zeros((0, size))
        self._action = np.full(size, np.nan)

    def see(self, command: FloatArray, action: FloatArray) -> tuple[BoolArray, BoolArray]:
        """Take a command and what was executed of it, shapes (m,).

        Returns
        -------
        tuple
            What is stuck above its command, at the low end of its range, and what is stuck below
            it, at the high end, each of shape (m,).
        """
        self._commands = np.vstack([self._commands[1 - _WINDOW :], command])
        still = np.abs(action - self._action) < _STILL * self._margin
        self._action = action
        if len(self._commands) < _WINDOW:
            return np.zeros_like(still), np.zeros_like(still)
        above = action - self._commands.max(axis=0) > self._margin
        below = self._commands.min(axis=0) - action > self._margin
        return still & above, still & below

    def pause(self) -> None:
        """Forget what was commanded lately."""
        self._commands = self._commands[:0]
        self._action = np.full_like(self._action, np.nan)

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {"commands": self._commands, "action": self._action}
        return SavedState(arrays, {"margin": self._margin})

    @classmethod
    def restore(cls, state: SavedState, size: int) -> "StuckWatch":
        """Return the watch whose snapshot this is; it continues bit for bit.

        Raises
        ------
        InvalidConfigError, InvalidArrayError
            If the arrays do not fit together.
        """
        watch = cls(size, float(state.settings["margin"]))
        watch._commands = matrix_or_empty("commands", state.arrays["commands"], size)
        watch._action = np.array(state.arrays["action"], dtype=np.float64)  # NaN after a pause
        if len(watch._commands) > _WINDOW or watch._action.shape != (size,):
            raise InvalidConfigError(
                f"{len(watch._commands)} commands and an action of shape {watch._action.shape} "
                f"do not go with {size} entries"
            )
        return watch
