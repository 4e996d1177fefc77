"""Moves the target of a feed-forward controller until the tip is where it should be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common.settings import check_settings, setting

Array = NDArray[np.float64]

_LONGEST_STEP = 1.0  # [s] over which one tip is integrated; beyond that it was not seen
_SMOOTHING = 0.5  # [s] over which the error is averaged before its direction is trusted
_CHECK_PERIOD = 1.0  # [s] between two looks at where the error has gone
_SLOWEST = 0.02  # [1/s] gain that no trunk is too slow for
_WORSE = 1.5  # times the first error, and the tolerance twice more: the corrections lead away


@dataclass(frozen=True)
class FeedbackSettings:
    """How the error of the tip is integrated, and when a movement is over."""

    gain: float = setting(
        0.2,
        "Motion of the target per error and time [1/s]; the trunk allows slow ones only",
        low=0.0,
        high=0.5,
    )
    feedforward_time: float = setting(
        3.0, "Time for the feed-forward movement before the error counts [s]", low=0.0
    )
    max_correction: float = setting(
        0.05, "Largest distance between target and goal [m]", low=0.0, high=0.5
    )
    max_speed: float = setting(0.02, "Largest speed of the target [m/s]", low=0.0)
    tolerance: float = setting(
        0.002, "Error within which the tip must stay to be there, if none is given [m]", low=0.0
    )
    rest_time: float = setting(3.0, "Time for which it must stay there [s]", low=0.0)
    timeout: float = setting(30.0, "Time after which a movement ends in any case [s]", low=0.5)

    def __post_init__(self) -> None:
        check_settings(self)


class GoalIntegrator:
    """Integral control in goal space, on top of any inverse model.

    ``target = goal + correction``, where the correction integrates ``gain * (goal - tip)``.

    A plant that follows its target with a lag tau stays stable for gains below about 1 / tau, and
    neither tau nor how far the tip goes with its target is known. So the gain is a wish: whenever
    the error has turned against itself, by more than the tolerance on both sides, the gain is
    halved for the rest of the movement (Kesten, "Accelerated stochastic approximation", 1958), and
    when the corrections have led farther away than feed-forward control was, they are taken back
    as well. Whatever the settings, what swings or runs away soon does so no more.

    Anti-windup: the correction is limited in size and speed, and stands still in the coordinates
    that do not count.

    Parameters
    ----------
    settings : Gain and limits.
    goal : Where the tip should be [m], shape (3,).
    axes : Number of leading coordinates that count, 2 or 3.
    start : Time at the beginning [s].
    tolerance, timeout : As of the settings; 0 takes those.
    """

    def __init__(
        self,
        settings: FeedbackSettings,
        goal: Array,
        *,
        axes: int,
        start: float,
        tolerance: float = 0.0,
        timeout: float = 0.0,
    ) -> None:
        self._settings = settings
        self._axes = axes
        self._start = self._last = self._outside = start
        self._tolerance = tolerance or settings.tolerance
        self._timeout = timeout or settings.timeout
        self._correction = np.zeros(3)
        self.gain = settings.gain
        """Gain now [1/s]."""
        self._smooth: Array | None = None  # error, averaged
        self._checked: Array | None = None  # what it was at the last check
        self._next_check = start + settings.feedforward_time
        self._first = np.inf  # error at the first check
        self._going_back = False
        self.goal = goal
        self.error = float("nan")
        self.elapsed = 0.0

    @property
    def target(self) -> Array:
        """Where the inverse model is to go now [m], shape (3,)."""
        return self.goal + self._correction

    @property
    def arrived(self) -> bool:
        """Whether the tip has stayed within the tolerance long enough."""
        near = self.error <= self._tolerance
        return near and self._last - self._outside >= self._settings.rest_time

    @property
    def done(self) -> bool:
        """Whether the movement is over: arrived, or out of time."""
        return self.arrived or self.elapsed >= self._timeout

    def update(self, time: float, tip: Array) -> Array:
        """Take a measured tip and move the target.

        Parameters
        ----------
        time : Robot time of the tip [s].
        tip : Measured position of the tip [m], shape (3,).

        Returns
        -------
        The target [m], shape (3,).
        """
        period, self._last = min(time - self._last, _LONGEST_STEP), time
        self.elapsed = time - self._start
        error = np.zeros(3)
        error[: self._axes] = (self.goal - tip)[: self._axes]
        self.error = float(np.linalg.norm(error))
        if not self.error <= self._tolerance:
            self._outside = time
        if self.elapsed > self._settings.feedforward_time:
            self._watch(time, period, error)
            wanted = self.gain * period * error
            if self._going_back:
                wanted = -self._correction
            motion = _limited(wanted, self._settings.max_speed * period)
            self._correction = _limited(self._correction + motion, self._settings.max_correction)
        return self.target

    def _watch(self, time: float, period: float, error: Array) -> None:
        """Lower the gain when the error swings, and go back when it grows."""
        if self._smooth is None:
            self._smooth = error
        self._smooth = self._smooth + min(1.0, period / _SMOOTHING) * (error - self._smooth)
        if time < self._next_check:
            return
        self._next_check = time + _CHECK_PERIOD
        before, now = self._checked, self._smooth
        size = float(np.linalg.norm(now))
        if before is None:
            self._first = size
        worse = size > _WORSE * self._first + 2.0 * self._tolerance
        if worse and not self._going_back:
            self._slow_down()
        self._going_back = worse
        swings = before is not None and size > self._tolerance and float(before @ now) < 0.0
        if swings and not worse:
            self._slow_down()
        if before is None or size > self._tolerance:
            self._checked = now

    def _slow_down(self) -> None:
        self.gain = max(0.5 * self.gain, min(self._settings.gain, _SLOWEST))


def _limited(vector: Array, length: float) -> Array:
    norm = float(np.linalg.norm(vector))
    return vector if norm <= length else vector * (length / norm)
