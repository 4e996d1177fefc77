"""Moves the target of a feed-forward controller until the tip is where it should be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_cartesian_feedback.correction_watch import CorrectionWatch
from bha_common.settings import check_settings, setting

Array = NDArray[np.float64]

_LONGEST_STEP = 1.0  # [s] over which one tip is integrated; beyond that it was not seen
_SMOOTHING = 0.5  # [s] over which the error is averaged before it is judged


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
        3.0,
        "Time for the feed-forward movement before the error counts [s]; before 1 s it is the way",
        low=1.0,
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

    The gain is a wish, and corrections are on trial, see `CorrectionWatch`: what swings or runs
    away is slowed down and taken back.

    A tracker's noise is integrated as it comes, but whether the tip is there, and what corrections
    do to it, is told by the error averaged over half a second.

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
        self._near = False  # whether the tip is within the tolerance
        self._tolerance = tolerance or settings.tolerance
        self._timeout = timeout or settings.timeout
        self._correction = np.zeros(3)
        self._smooth: Array | None = None  # error, averaged
        self._watch = CorrectionWatch(
            settings.gain, self._tolerance, start + settings.feedforward_time
        )
        self.goal = goal
        self.error = float("nan")
        self.elapsed = 0.0

    @property
    def gain(self) -> float:
        """Gain now [1/s]."""
        return self._watch.gain

    @property
    def target(self) -> Array:
        """Where the inverse model is to go now [m], shape (3,)."""
        return self.goal + self._correction

    @property
    def arrived(self) -> bool:
        """Whether the tip has stayed within the tolerance long enough."""
        return self._near and self._last - self._outside >= self._settings.rest_time

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
        gap, self._last = time - self._last, time
        period = min(gap, _LONGEST_STEP)
        self.elapsed = time - self._start
        error = np.zeros(3)
        error[: self._axes] = (self.goal - tip)[: self._axes]
        self.error = float(np.linalg.norm(error))
        if self._smooth is None:
            self._smooth = error
        self._smooth = self._smooth + min(1.0, period / _SMOOTHING) * (error - self._smooth)
        self._near = bool(np.linalg.norm(self._smooth) <= self._tolerance)
        if gap > _LONGEST_STEP or not self._near:
            self._outside = time
        if self.elapsed > self._settings.feedforward_time:
            limit = self._settings.max_correction
            correctable = _limited(self._correction + self._smooth, limit) - self._correction
            self._watch.look(time, self._smooth, self._correction, correctable)
            back = self._watch.back_to
            wanted = self.gain * period * error if back is None else back - self._correction
            motion = _limited(wanted, self._settings.max_speed * period)
            self._correction = _limited(self._correction + motion, limit)
        return self.target


def _limited(vector: Array, length: float) -> Array:
    norm = float(np.linalg.norm(vector))
    return vector if norm <= length else vector * (length / norm)
