"""The ends of what each entry of an action can really be, learned from where it got stuck.

A reading that is stuck (`StuckWatch`) came to an end of its range. The ends depend on the posture
(a bellows of a hanging trunk is stretched by the weight below it, more to the one side when it
bends) and move as the material creeps, so each is a function of the outcome, linear, learned in
steps that do not become smaller (normalised least mean squares; Widrow and Hoff, 1960):

    end(x) = e' [(x - x_home); 1]

A reading beyond an end proves it wrong. An end is explored by itself: exploratory noise is put on
after the command was held within the ends.
"""

import numpy as np

from bha_goal_babbling.arrays import FloatArray, matrix, vector
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.stuck_watch import StuckWatch

_STUCK, _PASSED = 0.3, 0.1
"""Share of the distance that an end moves when a reading stuck short of it, or passed it. An end
that lies too far out costs more (the outcome is missed) than one too far in (others make up)."""


class ReachableRange:
    """Lowest and highest action over outcomes.

    Parameters
    ----------
    home_outcome : array
        Where outcomes are counted from, shape (n,).
    low, high : array
        Ends as long as nothing got stuck, shape (m,).
    margin : float
        As of `StuckWatch`.
    """

    def __init__(
        self, home_outcome: FloatArray, low: FloatArray, high: FloatArray, margin: float
    ) -> None:
        self._home = home_outcome.copy()
        self._ends = np.zeros((2, low.size, home_outcome.size + 1))
        self._ends[0, :, -1], self._ends[1, :, -1] = low, high
        self._watch = StuckWatch(low.size, margin)

    def at(self, outcome: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the lowest and highest action at an outcome, shape (n,), each of shape (m,)."""
        low, high = self._ends @ self._place(outcome)
        # Ends that have passed each other meet in the middle.
        middle = 0.5 * (low + high)
        return np.minimum(low, middle), np.maximum(high, middle)

    def learn(self, command: FloatArray, action: FloatArray, outcome: FloatArray) -> None:
        """Learn from a command, what was executed of it, shapes (m,), and the outcome (n,)."""
        at_low, at_high = self._watch.see(command, action)
        place = self._place(outcome)
        for ends, stuck, inwards in ((self._ends[0], at_low, 1.0), (self._ends[1], at_high, -1.0)):
            missed = action - ends @ place
            share = np.where(inwards * missed < 0.0, _PASSED, np.where(stuck, _STUCK, 0.0))
            ends += np.outer(share * missed, place / (place @ place))

    def pause(self) -> None:
        """Forget what was commanded lately."""
        self._watch.pause()

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {
            "home": self._home,
            "low": self._ends[0].copy(),
            "high": self._ends[1].copy(),
        }
        return SavedState(arrays).joined(watch=self._watch.state())

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
        if high.shape != low.shape:
            raise InvalidConfigError(f"low has shape {low.shape}, high has {high.shape}")
        watch = StuckWatch.restore(state.part("watch"), len(low))
        ends = cls(home, low[:, -1], high[:, -1], 0.0)
        ends._ends = np.stack([low, high])
        ends._watch = watch
        return ends

    def _place(self, outcome: FloatArray) -> FloatArray:
        return np.append(outcome - self._home, 1.0)
