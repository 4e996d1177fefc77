"""One stretch of goal babbling on the robot: go where it begins, then explore step by step."""

import math
from collections.abc import Callable

import numpy as np

from bha_goal_babbling.arrays import LARGEST, FloatArray
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.observation_window import Observation
from bha_goal_babbling.task import Task


class NotFollowingError(GoalBabblingError):
    """The robot does not go where it is told to, so there is nothing to learn from."""


class BabblingSession:
    """Asks a babbler for lengths, gives the robot time, and tells what came of them.

    A new babbler begins at home: the session goes there, waits, and takes the tip it sees for the
    home outcome. A babbler that has learned before goes on with the very step it was at.

    Parameters
    ----------
    task : Task
        What is learned.
    settings : LearnerSettings
        Times and tolerances.
    duration : float
        Robot time to explore, the way to the beginning included [s].
    babbler : GoalBabbler or None
        The babbler to go on with; None starts a new one.
    rng : numpy.random.Generator
        Randomness of a new babbler.
    on_sample : callable, optional
        Called with the measured lengths (9,) [m] and the outcome (n,) [m] of each sample.
    """

    def __init__(
        self,
        task: Task,
        settings: LearnerSettings,
        duration: float,
        babbler: GoalBabbler | None,
        rng: np.random.Generator,
        on_sample: Callable[[FloatArray, FloatArray], None] | None = None,
    ) -> None:
        self._task = task
        self._settings = settings
        self._rng = rng
        self._on_sample = on_sample
        self.babbler = babbler
        self._periods = math.ceil(duration / settings.command_period - 1e-9)
        self._settling = math.ceil(settings.settling_time / settings.command_period - 1e-9)
        self._elapsed = 0
        if babbler is None:
            self._command = task.home_action
        else:
            babbler.pause()  # it comes to rest at the step it goes on with
            self._command = babbler.ask()
        self._next_observation = self._settling
        self._follows = False
        self.samples = 0
        """Number of steps that were told what came of them."""

    @property
    def elapsed(self) -> float:
        """Robot time since the beginning [s]."""
        return self._elapsed * self._settings.command_period

    @property
    def settling(self) -> bool:
        """Whether the robot is on its way to where exploration begins."""
        return self._elapsed <= self._settling

    @property
    def done(self) -> bool:
        """Whether the time is over."""
        return self._elapsed >= self._periods

    def update(self, observation: Observation) -> FloatArray:
        """Take what is seen at a command period and tell the lengths to command now.

        Parameters
        ----------
        observation : Observation
            Lengths and tip now. Without a tip, or with an absurd one, nothing is learned and the
            robot waits.

        Returns
        -------
        array
            Lengths to command [m], shape (9,).

        Raises
        ------
        NotFollowingError
            When the lengths are far from the command after the time to settle.
        """
        if self._elapsed >= self._next_observation and _usable(observation):
            assert observation.tip is not None
            if not self._follows:
                self._check_following(observation)
                self._follows = True
            self._command = self._step(observation.lengths, self._task.outcome(observation.tip))
            self._next_observation = self._elapsed + self._settings.step_periods
        self._elapsed += 1
        return self._command

    def _step(self, lengths: FloatArray, outcome: FloatArray) -> FloatArray:
        if self.babbler is None:
            self.babbler = GoalBabbler(
                self._task.config,
                self._task.goals(),
                self._task.home_action,
                outcome,
                self._task.action_low,
                self._task.action_high,
                self._rng,
            )
        else:
            self.babbler.tell(lengths, outcome)
            self.samples += 1
            if self._on_sample is not None:
                self._on_sample(lengths, outcome)
        return self.babbler.ask()

    def _check_following(self, observation: Observation) -> None:
        error = float(np.mean(np.abs(observation.lengths - self._command)))
        if error > self._settings.following_tolerance:
            raise NotFollowingError(
                f"the lengths are {error * 1e3:.0f} mm from the command on average after "
                f"{self._settings.settling_time:g} s; does the pressure controller have a model "
                "(identify), and is the robot under pressure?"
            )


def _usable(observation: Observation) -> bool:
    """Tell whether a babbler would take an observation; one wrong reading ends no exploration."""
    if observation.tip is None:
        return False
    seen = np.concatenate([observation.lengths, observation.tip])
    return bool((np.abs(seen) <= LARGEST).all())  # false for NaN as well
