"""The ends of what each entry of an action can really be, learned from where it got stuck.

What was commanded lately spans an interval. A reading within it followed; one that stays outside
of it, beyond a margin, came to an end of its range. The ends depend on the posture (a bellows of
a hanging trunk is stretched by the weight below it, more to the one side when it bends) and move
as the material creeps, so each is a function of the outcome, linear, learned in steps that do not
become smaller (normalised least mean squares; Widrow and Hoff, 1960):

    end(x) = e' [(x - x_home); 1]

A reading beyond an end proves it wrong. An end is explored by itself: exploratory noise is put on
after the command was held within the ends.
"""

import numpy as np

from bha_goal_babbling.arrays import FloatArray, matrix, matrix_or_empty, vector
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState

_WINDOW = 4
"""Commands that a reading may still be following; lags of the robot are shorter."""
_STUCK, _PASSED = 0.3, 0.1
"""Share of the distance that an end moves when a reading stuck short of it, or passed it. An end
that lies too far out costs more (the outcome is missed) than one too far in (others make up)."""
_STILL = 0.4
"""Largest step of a reading that is stuck, in margins: one that moves is still on its way."""


class ReachableRange:
    """Lowest and highest action over outcomes.

    Parameters
    ----------
    home_outcome : array
        Where outcomes are counted from, shape (n,).
    low, high : array
        Ends as long as nothing got stuck, shape (m,).
    margin : float
        How far a reading must lie outside of what was commanded, while it keeps still, to be
        stuck, in the unit of actions.
    """

    def __init__(
        self, home_outcome: FloatArray, low: FloatArray, high: FloatArray, margin: float
    ) -> None:
        self._home = home_outcome.copy()
        self._margin = margin
        self._ends = np.zeros((2, low.size, home_outcome.size + 1))
        self._ends[0, :, -1], self._ends[1, :, -1] = low, high
        self._commands = np.zeros((0, low.size))
        self._action = np.full(low.size, np.nan)

    def at(self, outcome: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lowest and highest action at an outcome, shape (n,), each of shape (m,)."""
        low, high = self._ends @ self._place(outcome)
        # Ends that have passed each other meet in the middle.
        middle = 0.5 * (low + high)
        return np.minimum(low, middle), np.maximum(high, middle)

    def learn(self, command: FloatArray, action: FloatArray, outcome: FloatArray) -> None:
        """Learn from a command, what was executed of it, shapes (m,), and the outcome (n,)."""
        self._commands = np.vstack([self._commands[1 - _WINDOW :], command])
        still = np.abs(action - self._action) < _STILL * self._margin
        self._action = action
        if len(self._commands) < _WINDOW:
            return
        place = self._place(outcome)
        for ends, followed, inwards in (
            (self._ends[0], self._commands.max(axis=0), 1.0),
            (self._ends[1], self._commands.min(axis=0), -1.0),
        ):
            missed = action - ends @ place
            stuck = still & (inwards * (action - followed) > self._margin)
            share = np.where(inwards * missed < 0.0, _PASSED, np.where(stuck, _STUCK, 0.0))
            ends += np.outer(share * missed, place / (place @ place))

    def pause(self) -> None:
        """Forget what was commanded lately."""
        self._commands = self._commands[:0]
        self._action = np.full_like(self._action, np.nan)

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {
            "home": self._home,
            "low": self._ends[0].copy(),
            "high": self._ends[1].copy(),
            "commands": self._commands,
            "action": self._action,
        }
        return SavedState(arrays, {"margin": self._margin})

    @classmethod
    def restore(cls, state: SavedState) -> "ReachableRange":
        """Return the range whose snapshot this is; it continues bit for bit.

        Raises
        ------
        InvalidConfigError, InvalidArrayError
            If the arrays do not fit together.
        """
        home = vector("home", state.arrays["home"])
        low, high = (matrix(k, state.arrays[k], home.size + 1) for k in ("low", "high"))
        commands = matrix_or_empty("commands", state.arrays["commands"], len(low))
        action = np.array(state.arrays["action"], dtype=np.float64)  # NaN after a pause
        if high.shape != low.shape or len(commands) > _WINDOW or action.shape != (len(low),):
            raise InvalidConfigError(
                f"ends of shapes {low.shape} and {high.shape} do not go with {len(commands)} "
                f"commands and an action of shape {action.shape}"
            )
        ends = cls(home, low[:, -1], high[:, -1], float(state.settings["margin"]))
        ends._ends = np.stack([low, high])
        ends._commands, ends._action = commands, action
        return ends

    def _place(self, outcome: FloatArray) -> FloatArray:
        return np.append(outcome - self._home, 1.0)
