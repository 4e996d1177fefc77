"""The learner as a whole, one length command after the other: idle, babbling, reaching, holding.

It is told lengths and tip as they come, and asked for a command every command period. It knows the
robot's time, but no topics, files or clocks.
"""

import math
from collections.abc import Callable

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbling_session import BabblingSession
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.found_ends import FoundEnds
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.observation_window import Observation, ObservationWindow
from bha_goal_babbling.practice import Practice
from bha_goal_babbling.reach import Reach
from bha_goal_babbling.task import Task

_SENT_ON = 1e-3
"""Change of a command below which the robot stays where it is, at an end or not [m]."""
_TARGET_MARGIN = 0.2
"""How far outside of the task's region a target may lie [m]: feedback may correct that far."""


class RefusedError(GoalBabblingError):
    """The learner cannot do now what it was asked for; the message says why."""


class Learner:
    """Commands lengths, explores and learns when asked to, and goes to goals.

    Parameters
    ----------
    settings : LearnerSettings
        Times and tolerances.
    task : Task
        What is learned.
    babbler : GoalBabbler, optional
        What was learned before.
    """

    IDLE, HOMING, BABBLING = "idle", "homing", "babbling"
    REACHING, HOLDING, STOPPED = "reaching", "holding", "stopped"

    def __init__(
        self, settings: LearnerSettings, task: Task, babbler: GoalBabbler | None = None
    ) -> None:
        self.settings = settings
        self.task = task
        self.babbler = babbler
        self.exploration_time = 0.0
        self.goals_set = 0
        self.on_sample: Callable[[FloatArray, FloatArray], None] | None = None
        self._window = ObservationWindow(round(settings.observation_span * 1e9))
        self._rng = np.random.default_rng(settings.seed)
        self._session: BabblingSession | None = None
        self._reach: Reach | None = None
        self._practice = Practice(task, settings)
        self._ends = FoundEnds(task.home_action.size)
        self._goal: FloatArray | None = None
        self._sent: FloatArray | None = None  # for the goal, before others made up for any end
        self._command: FloatArray | None = None
        self._stopped = False
        self._failure = ""
        self._resting = self.IDLE

    @property
    def mode(self) -> str:
        """What the learner does now, one of the constants of this class."""
        if self._stopped:
            return self.STOPPED
        if self._session is not None:
            return self.HOMING if self._session.settling else self.BABBLING
        return self.REACHING if self._reach is not None else self._resting

    @property
    def session(self) -> BabblingSession | None:
        """The babbling that runs; None when none does."""
        return self._session

    @property
    def reach(self) -> Reach | None:
        """The movement to a goal that runs; None when none does."""
        return self._reach

    @property
    def goal(self) -> FloatArray | None:
        """Goal of the present movement, or target followed last [m], shape (n,)."""
        return self._goal

    @property
    def failure(self) -> str:
        """Why the last babbling ended early or without a sample; empty when it did not."""
        return self._failure

    @property
    def practised(self) -> int:
        """Number of examples taken from goals of others."""
        return self._practice.examples

    @property
    def newest_tip(self) -> int | None:
        """Time of the newest tip [ns]; None when none was seen lately."""
        return self._window.newest_tip

    def see_lengths(self, time: int, lengths: FloatArray) -> None:
        """Take measured lengths [m], shape (9,), of robot time [ns]."""
        self._window.add_lengths(time, lengths)

    def see_tip(self, time: int, tip: FloatArray) -> None:
        """Take a measured tip [m], shape (3,), of robot time [ns]."""
        self._window.add_tip(time, tip)

    def update(self, time: int) -> FloatArray | None:
        """Compute the command of one command period.

        Parameters
        ----------
        time : int
            Robot time of the command [ns].

        Returns
        -------
        array or None
            Lengths to command [m], shape (9,); None while no lengths were seen.
        """
        observation = self._window.at(time)
        if observation is None:
            return self._command
        if self._stopped or self._command is None:
            self._command = observation.lengths
        if self._session is not None:
            self._babble(observation)
        else:
            self._use(observation)
        return self._command

    def babble(self, duration: float, *, restart: bool = False) -> BabblingSession:
        """Begin to explore.

        Parameters
        ----------
        duration : float
            Robot time to explore [s].
        restart : bool
            Whether to forget what was learned before.

        Raises
        ------
        RefusedError
            When it cannot be done now, or the duration is not valid.
        """
        reason = self.why_not_babble(duration)
        if reason:
            raise RefusedError(reason)
        if restart:
            self.babbler = None
            self.exploration_time = 0.0
        self._failure = ""
        self._reach = self._goal = None
        self._session = BabblingSession(
            self.task, self.settings, duration, self.babbler, self._rng, self.on_sample
        )
        return self._session

    def why_not_babble(self, duration: float) -> str:
        """Tell why `babble` would be refused now; empty when it would not."""
        if not (math.isfinite(duration) and duration > 0.0):
            return f"duration must be above 0 s, got {duration}"
        return self._why_busy()

    def go_to(self, tip: FloatArray, tolerance: float = 0.0, timeout: float = 0.0) -> Reach:
        """Begin a movement to a goal, with what is learned alone.

        Parameters
        ----------
        tip : array
            Where the tip should go [m], shape (3,); coordinates the task leaves open are ignored.
        tolerance, timeout : float
            As of `Reach`.

        Raises
        ------
        RefusedError
            When it cannot be done now, or the goal lies outside of what the task covers.
        """
        self._check_free()
        goal = self.task.outcome(tip)
        reason = self.task.why_refused(goal)
        if reason is not None:
            raise RefusedError(f"the goal is refused: {reason}")
        for name, value in (("tolerance", tolerance), ("timeout", timeout)):
            if not (math.isfinite(value) and value >= 0.0):
                raise RefusedError(f"{name} must be 0 or above, got {value}")
        self._ends.begin(goal)
        self._command = self._sent = self._inverse(goal)
        self._resting = self.HOLDING
        self._practice.begin()
        self._goal = goal
        self.goals_set += 1
        self._reach = Reach(self.task, self.settings, goal, tolerance, timeout)
        return self._reach

    def follow(self, target: FloatArray) -> None:
        """Take a target (3,) [m] that somebody else moves, such as Cartesian feedback.

        It ends a movement of the learner's own. Targets may lie a little outside of the task's
        region, so that feedback can reach its edge; the inverse model's limits still hold.

        Raises
        ------
        RefusedError
            When it cannot be done now, or the target lies far outside.
        """
        self._check_free()
        goal = self.task.outcome(target)
        reason = self.task.why_refused(goal, _TARGET_MARGIN)
        if reason is not None:
            raise RefusedError(f"the target is refused: {reason}")
        self._ends.follow(goal)
        command = self._inverse(goal)
        self._reach = self._sent = None
        self._goal = goal
        self._resting = self.HOLDING
        self._practice.begin()
        self._command = command

    def halt(self) -> None:
        """End babbling or a movement; what was learned stays, and the last command holds."""
        self._practice.end()
        if self._session is not None:
            self._end_session()
        self._reach = self._sent = None

    def stop(self, stopped: bool) -> None:
        """Begin or end the emergency stop.

        While it is active the command follows the lengths, so that nothing moves at its end.
        """
        if stopped:
            self.halt()
            self._command = self._goal = None
            self._resting = self.IDLE
        self._stopped = stopped

    def robot_restarted(self) -> None:
        """Forget what was seen of a robot whose time has begun anew, and hold where it is."""
        self.halt()
        self._window.clear()
        self._command = self._goal = None
        self._resting = self.IDLE

    def use(self, babbler: GoalBabbler, exploration_time: float = 0.0) -> None:
        """Go on with what another learner has learned in some exploration time [s].

        Raises
        ------
        RefusedError
            When it babbles, or the babbler belongs to a task of another size.
        """
        self._check_free()
        if babbler.home_outcome.size != self.task.outcome_size:
            raise RefusedError(
                f"the model has {babbler.home_outcome.size} coordinates, but task "
                f"{self.task.name} has {self.task.outcome_size}"
            )
        actions = babbler.inverse(babbler.home_outcome).size
        if actions != self.task.home_action.size:
            raise RefusedError(
                f"the model has {actions} lengths, but this robot has {self.task.home_action.size}"
            )
        self.babbler = babbler
        self.exploration_time = exploration_time

    def _babble(self, observation: Observation) -> None:
        session = self._session
        assert session is not None
        if session.done:
            if not session.samples:
                self._failure = (
                    f"nothing was explored in {session.elapsed:g} s: the way to where exploration "
                    f"begins takes {self.settings.settling_time:g} s, and then the tip must be seen"
                )
            self._end_session()
            return
        try:
            self._command = session.update(observation)
        except GoalBabblingError as error:
            self._failure = str(error)
            self._end_session()
            return
        self.babbler = session.babbler
        self.exploration_time += self.settings.command_period

    def _use(self, observation: Observation) -> None:
        """Watch a robot that moves to goals of others, and learn from it what is wanted."""
        if self.babbler is not None and not self._stopped:
            self._practice.see(self.babbler, observation)
        self._make_up_for_ends(observation.lengths)
        if self._reach is not None:
            self._reach.update(observation.tip)
            if self._reach.result is not None:
                self._reach = None

    def _make_up_for_ends(self, lengths: FloatArray) -> None:
        """Let other lengths make up for those that have come to an end on the way to a goal."""
        if self._goal is None or self._command is None:
            return
        if not self._ends.see(self._command, lengths):
            return
        if self._ends.given_up:
            command = self._sent
        elif self._reach is not None:
            command = self._inverse(self._goal)
        else:
            return  # a posture is held; targets are solved anew all the time
        if command is not None and np.abs(command - self._command).max() > _SENT_ON:
            self._command = command
            if self._reach is not None:
                self._reach.moves_on()

    def _end_session(self) -> None:
        self._session = None
        self._resting = self.HOLDING
        if self.babbler is None:  # it did not get beyond the way home
            self.exploration_time = 0.0

    def _inverse(self, goal: FloatArray) -> FloatArray:
        if self.babbler is None:
            raise RefusedError("nothing is learned yet: babble first, or load a model")
        return self.babbler.inverse(goal, self._ends.low, self._ends.high)

    def _check_free(self) -> None:
        reason = self._why_busy()
        if reason:
            raise RefusedError(reason)

    def _why_busy(self) -> str:
        if self._stopped:
            return "the emergency stop is active: reset it first"
        if self._session is not None:
            return (
                "it babbles and accepts nothing else until that ends "
                f"({self._session.elapsed:.0f} s so far); cancel the babbling first"
            )
        return ""
