"""One movement to a goal: when it is over, and what came of it."""

import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.task import Task


@dataclass(frozen=True, eq=False)
class ReachResult:
    """How a movement ended.

    Attributes
    ----------
    settled : bool
        Whether the tip came to rest, and within the tolerance if there was one.
    tip : array or None
        Last position of the tip [m], shape (3,); None when it was never seen.
    error : float
        Distance between goal and tip in the task's coordinates [m]; NaN without a tip.
    duration : float
        Robot time of the movement [s].
    """

    settled: bool
    tip: FloatArray | None
    error: float
    duration: float


class Reach:
    """Watches the tip on its way to a goal.

    The attribute `result` is None until the movement has ended by itself.

    Parameters
    ----------
    task : Task
        Says which coordinates count.
    settings : LearnerSettings
        When the tip is at rest, and the timeout.
    goal : array
        The goal [m], shape (n,).
    tolerance : float
        Distance within which the tip must come to rest [m]; 0 takes any.
    timeout : float
        Robot time after which the movement ends in any case [s]; 0 takes that of the settings.
    """

    def __init__(
        self,
        task: Task,
        settings: LearnerSettings,
        goal: FloatArray,
        tolerance: float = 0.0,
        timeout: float = 0.0,
    ) -> None:
        self._task = task
        self._settings = settings
        self.goal = goal
        self.result: ReachResult | None = None
        self._tolerance = tolerance
        self._timeout = timeout or settings.reach_timeout
        self._elapsed = 0
        self._tip: FloatArray | None = None
        periods = max(1, round(settings.rest_time / settings.command_period))
        self._trail: deque[FloatArray] = deque(maxlen=periods + 1)

    @property
    def elapsed(self) -> float:
        """Robot time since the beginning [s]."""
        return self._elapsed * self._settings.command_period

    @property
    def error(self) -> float:
        """Distance between goal and tip in the task's coordinates now [m]; NaN without a tip."""
        if self._tip is None:
            return math.nan
        return float(np.linalg.norm(self._task.outcome(self._tip) - self.goal))

    @property
    def tip(self) -> FloatArray | None:
        """Position of the tip now [m], shape (3,); None when it was not seen."""
        return self._tip

    def update(self, tip: FloatArray | None) -> None:
        """Take the tip (3,) [m] at a command period; sets `result` when the movement is over."""
        if tip is not None:
            self._tip = tip
            self._trail.append(tip)
        settled = self._at_rest() and (not self._tolerance or self.error <= self._tolerance)
        if settled or self.elapsed >= self._timeout:
            self.result = ReachResult(settled, self._tip, self.error, self.elapsed)
        else:
            self._elapsed += 1

    def moves_on(self) -> None:
        """Take note that the robot was sent on: it is not at rest, even if it was."""
        self._trail.clear()

    def _at_rest(self) -> bool:
        if len(self._trail) != self._trail.maxlen:
            return False
        trail = np.array(self._trail)
        moved = np.linalg.norm(trail - trail[-1], axis=1).max()
        return bool(moved <= self._settings.rest_distance)
