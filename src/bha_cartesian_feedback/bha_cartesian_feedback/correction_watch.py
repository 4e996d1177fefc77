"""Watches what a correction does to the error: lowers the gain, and takes back what is in vain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_CHECK_PERIOD = 1.0  # [s] between two looks at where the error has gone
_LAG_CHECKS = 3  # looks after which the tip has followed its target well enough to judge by
_SLOWEST = 0.02  # [1/s] gain that no trunk is too slow for
_ROOM = 2.0  # times the first error, and the tolerance as often: how far a correction may try
_WORSE = 1.5  # times the first error, and the tolerance twice more: the corrections lead away


class CorrectionWatch:
    """Tells with which gain errors are to be corrected, and when to go back.

    A plant that follows its target with a lag tau stays stable for gains below about 1 / tau, and
    neither tau nor how far the tip goes with its target is known. So the gain is a wish, halved as
    the error turns (Kesten, "Accelerated stochastic approximation", 1958): whenever it points
    against where it pointed when it last turned, both beyond the tolerance. So a tip that goes
    round its goal turns as well as one that swings through it, and one at the limit of corrections
    by what it does along the limit. The first turn costs nothing: a sound movement may overshoot.

    Where the tip cannot follow, as at the end of a bellows' range, a correction grows nevertheless,
    until the inverse model answers with another posture. So one that has gone twice the first error
    beyond where the error was least, or that has led half as far again away as feed-forward control
    was, is taken back to there, and if that was in vain, to half of it; the gain is halved too.

    Parameters
    ----------
    gain : Gain to begin with [1/s].
    tolerance : Error that needs no correction [m].
    first_check : Time from which on errors are those of corrections [s].
    """

    def __init__(self, gain: float, tolerance: float, first_check: float) -> None:
        self.gain = gain
        """Gain now [1/s]."""
        self.back_to: Array | None = None
        """The correction to go back to [m], shape (3,); None while it may go on."""
        self._lowest_gain = min(gain, _SLOWEST)
        self._tolerance = tolerance
        self._next_check = first_check
        self._turned_to: Array | None = None  # the error when it last turned, or at first
        self._has_turned = False
        self._first_checks = _LAG_CHECKS  # still to come
        self._first = 0.0  # largest error at those
        self._least = np.inf
        self._best = np.zeros(3)  # the correction that has brought the least error
        self._tried = [self._best] * _LAG_CHECKS  # corrections at the last checks
        self._in_vain = False  # whether no smaller error was found since it went back

    def look(self, time: float, error: Array, correction: Array, correctable: Array) -> None:
        """Take the error that there is with a correction.

        Parameters
        ----------
        time : Robot time [s].
        error : Way from the tip to the goal, without the tracker's noise [m], shape (3,).
        correction : Way from the goal to the target [m], shape (3,).
        correctable : The error, as far as the limit of corrections lets it be corrected [m],
            shape (3,).
        """
        if time < self._next_check:
            return
        self._next_check = time + _CHECK_PERIOD
        if self.back_to is not None:
            if np.allclose(correction, self.back_to, rtol=0.0, atol=1e-6):
                self._next_check = time + _LAG_CHECKS * _CHECK_PERIOD
                self.back_to = self._turned_to = None
            return
        self._check_way(error, correction)
        if self.back_to is None:
            self._check_turn(correctable)

    def _check_way(self, error: Array, correction: Array) -> None:
        size = float(np.linalg.norm(error))
        if self._first_checks > 0:
            self._first, self._first_checks = max(self._first, size), self._first_checks - 1
        if size < self._least or size <= self._tolerance:
            # The tip is late: what it shows now has come of what was tried a while ago.
            self._least, self._best, self._in_vain = size, self._tried[0], False
        elif self._is_lost(size, correction):
            self._best = self._best * (0.5 if self._in_vain else 1.0)
            self.back_to, self._in_vain = self._best, True
            self._slow_down()
            return
        self._tried = [*self._tried[1:], correction]

    def _check_turn(self, correctable: Array) -> None:
        if np.linalg.norm(correctable) <= self._tolerance:
            return
        if self._turned_to is not None:
            if float(self._turned_to @ correctable) >= 0.0:
                return
            if self._has_turned:
                self._slow_down()
            self._has_turned = True
        self._turned_to = correctable

    def _is_lost(self, size: float, correction: Array) -> bool:
        away = float(np.linalg.norm(correction - self._best))
        return (
            away > _ROOM * (self._first + self._tolerance)
            or size > _WORSE * self._first + 2.0 * self._tolerance
        )

    def _slow_down(self) -> None:
        self.gain = max(0.5 * self.gain, self._lowest_gain)
