"""Plant, controller and learner composed in one process, without ROS.

They are called in the order in which messages flow in lockstep, so the samples are those of the
graph, bit for bit; it serves experiments over many robots.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bha_cartesian_feedback.goal_integrator import FeedbackSettings, GoalIntegrator
from bha_common.command_gate import CommandGate, SafetySettings
from bha_goal_babbling.learner import Learner, RefusedError
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.reach import ReachResult
from bha_goal_babbling.task import Task
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from bha_pressure_ctrl.pressure_control import PressureControl, PressureControlSettings
from bha_sim.plant import Plant
from bha_sim.robot_parameters import RobotParameters, draw_robot, load_parameters

Array = NDArray[np.float64]

_TRACKER = 2  # sets the tracker's noise apart from everything else that a seed draws


class InProcessRobot:
    """A simulated robot with its controller and its learner.

    Parameters
    ----------
    task : What is learned.
    seed : Draws the robot, its noise, the identification and the exploration.
    parameters : The mean robot; None takes the one of bha_sim.
    tip_period : Time between two positions of the tip [s].
    tip_noise : Standard deviation of each coordinate of the tip as the tracker sees it [m].
    learner_settings, control_settings : None takes the defaults, with `seed`.
    model : Equilibrium model of the pressure controller; None starts without.
    """

    def __init__(
        self,
        task: Task,
        *,
        seed: int = 0,
        parameters: RobotParameters | None = None,
        tip_period: float = 0.1,
        tip_noise: float = 0.0,
        learner_settings: LearnerSettings | None = None,
        control_settings: PressureControlSettings | None = None,
        model: EquilibriumModel | None = None,
    ) -> None:
        control_settings = control_settings or PressureControlSettings(seed=seed)
        learner_settings = learner_settings or LearnerSettings(seed=seed)
        period = control_settings.control_period
        robot = draw_robot(parameters or load_parameters(), seed)
        self.plant = Plant(robot, seed=seed, control_period=period)
        self.control = PressureControl(control_settings, model)
        self.learner = Learner(learner_settings, task)
        self._gate = CommandGate(SafetySettings())
        self._period = period
        self._period_ns = round(period * 1e9)
        self._command_ns = round(learner_settings.command_period * 1e9)
        self._tip_ns = round(tip_period * 1e9)
        self._tip_noise = tip_noise
        self._tracker = np.random.default_rng([seed, _TRACKER])
        self._integrator: GoalIntegrator | None = None
        self.tick = 0

    @property
    def time(self) -> float:
        """Robot time now [s]; it starts one control period after 0, as the simulator's does."""
        return self._now * 1e-9

    @property
    def _now(self) -> int:
        return (self.tick + 1) * self._period_ns

    def step(self) -> None:
        """Advance by one control period."""
        state = self.plant.state
        now = self._now
        time = now * 1e-9
        if now % self._tip_ns == 0:
            tip = state.tip
            if self._tip_noise:
                tip = tip + self._tip_noise * self._tracker.standard_normal(3)
            self.learner.see_tip(now, tip)
            if self._integrator is not None:
                self._correct(time, tip)
        self.learner.see_lengths(now, state.lengths)
        if now % self._command_ns == 0:
            command = self.learner.update(now)
            if command is not None:
                self.control.command(time, command)
        self._gate.offer(time, self.control.update(time, state.lengths))
        self.plant.step(self._gate.pressures(time, self._period))
        self.tick += 1

    def run_until(self, condition: Callable[[], bool], limit: float) -> bool:
        """Advance until a condition holds or `limit` [s] of robot time has passed.

        Returns
        -------
        Whether the condition holds.
        """
        end = self.tick + round(limit / self._period)
        while not condition():
            if self.tick >= end:
                return False
            self.step()
        return True

    def identify(self, samples: int | None = None) -> EquilibriumModel:
        """Collect settled samples, fit the equilibrium model and use it."""
        identification = self.control.identify(samples)
        self.run_until(lambda: identification.done, limit=86_400.0)
        return self.control.finish_identification()

    def babble(self, duration: float) -> None:
        """Explore for a robot time [s]."""
        self.learner.babble(duration)
        self.run_until(lambda: self.learner.session is None, limit=duration + 60.0)
        if self.learner.failure:
            raise RuntimeError(self.learner.failure)

    def reach_with_feedback(
        self,
        tip: Array,
        settings: FeedbackSettings | None = None,
        watch: Callable[[], None] | None = None,
    ) -> GoalIntegrator:
        """Go to a goal (3,) [m], corrected by the tip as it is seen, and tell what came of it.

        Parameters
        ----------
        tip : The goal [m], shape (3,).
        settings : Of the feedback; None takes the defaults.
        watch : Called after every control period.
        """
        settings = settings or FeedbackSettings()
        self.learner.go_to(tip)
        integrator = self._integrator = GoalIntegrator(
            settings, tip, axes=self.learner.task.outcome_size, start=self.time
        )

        def over() -> bool:
            if watch is not None:
                watch()
            return integrator.done

        self.run_until(over, limit=settings.timeout + 1.0)
        self._integrator = None
        return integrator

    def _correct(self, time: float, tip: Array) -> None:
        assert self._integrator is not None
        with contextlib.suppress(RefusedError):  # far outside: as in the graph the last one holds
            self.learner.follow(self._integrator.update(time, tip))

    def reach(self, tip: Array) -> ReachResult:
        """Go to a goal (3,) [m], feed-forward, and tell what came of it."""
        reach = self.learner.go_to(tip)
        self.run_until(lambda: reach.result is not None, limit=3600.0)
        assert reach.result is not None
        return reach.result
