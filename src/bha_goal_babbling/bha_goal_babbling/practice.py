"""Learning goes on while the robot is used: examples out of movements to other people's goals.

Every posture on the way is an example of lengths and the tip they bring, as good as one of
exploration. A robot that stands still teaches nothing new: an example is taken when the tip has
moved on by a step, and one more when the movement has come to rest, where it is most exact.

Sensors drift whether a robot explores or is used, so their offsets are followed as it comes; what
else was learned changes only where that is asked for.
"""

from __future__ import annotations

import math

import numpy as np

from bha_goal_babbling.arrays import LARGEST, FloatArray
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.observation_window import Observation
from bha_goal_babbling.task import Task


class Practice:
    """Picks the examples out of what is seen of a robot in use.

    Parameters
    ----------
    task : Task
        Says which coordinates count.
    settings : LearnerSettings
        `learn_in_use`, `use_step`, and when the tip is at rest.
    """

    def __init__(self, task: Task, settings: LearnerSettings) -> None:
        self._task = task
        self._lesson = settings.learn_in_use
        self._step = settings.use_step
        self._rest_distance = settings.rest_distance
        self._rest_periods = math.ceil(settings.rest_time / settings.command_period - 1e-9)
        self.examples = 0
        """Number of examples taken."""
        self.end()

    def begin(self) -> None:
        """Expect movement: a goal was set."""
        self._moving = self._lesson != "nothing"
        self._still = 0

    def end(self) -> None:
        """Take the movement for none to learn from any more."""
        self._moving = False
        self._still = 0
        self._last: FloatArray | None = None
        self._anchor: FloatArray | None = None

    def see(self, babbler: GoalBabbler, observation: Observation) -> None:
        """Let a babbler take lengths and tip of a command period, if they are worth it."""
        if not self._moving or observation.tip is None:
            return
        seen = np.concatenate([observation.lengths, observation.tip])
        if not (np.abs(seen) <= LARGEST).all():  # true for NaN as well
            return
        outcome = self._task.outcome(observation.tip)
        rests = self._rests(outcome)
        moved = self._last is None or np.linalg.norm(outcome - self._last) >= self._step
        if not (moved or rests):
            return
        if self._last is not None:  # the first one is where steps are counted from
            if self._lesson == "everything":
                babbler.practise(observation.lengths, outcome)
            else:
                babbler.follow_offsets(observation.lengths, outcome)
            self.examples += 1
        self._last = outcome
        self._moving = not rests

    def _rests(self, outcome: FloatArray) -> bool:
        """Whether the tip has stayed where it is for the time to rest."""
        if self._anchor is None or np.linalg.norm(outcome - self._anchor) > self._rest_distance:
            self._anchor, self._still = outcome, 0
        self._still += 1
        return self._still > self._rest_periods
