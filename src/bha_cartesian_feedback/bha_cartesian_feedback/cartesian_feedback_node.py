"""Cartesian feedback as a node: the tip and goals in, targets for the learner out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from bha_interfaces.msg import LearningStatus
from bha_interfaces.srv import SetGoal
from geometry_msgs.msg import PointStamped, PoseStamped
from numpy.typing import NDArray
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.task import Future
from std_msgs.msg import Bool

from bha_cartesian_feedback.goal_integrator import FeedbackSettings, GoalIntegrator
from bha_common.ros_goals import GoalServer, Mover
from bha_common.ros_messages import (
    MessageError,
    goal_from,
    nanoseconds,
    point_message,
)
from bha_common.ros_node import CONTROL_QOS, LATCHED_QOS, OK, WARN, BhaNode, exit_with, run
from bha_common.ros_parameters import declare_settings
from bha_common.settings import check_settings, setting
from bha_common.stamps import StreamClock

Array = NDArray[np.float64]
_MAX_GAP = 10.0  # [s] between two tips; more is doubted
_LEARNER_TIMEOUT = 2.0  # [s] of wall time
_ACCEPTING = {LearningStatus.IDLE, LearningStatus.REACHING, LearningStatus.HOLDING}


@dataclass(frozen=True)
class NodeSettings:
    """What belongs to the node rather than to the feedback."""

    axes: int = setting(
        3, "Leading coordinates of the tip that count: 2 (x, y) or 3", low=2, high=3
    )

    def __post_init__(self) -> None:
        check_settings(self)


class CartesianFeedback(BhaNode):
    """Reaches goals more exactly and more slowly than the learner alone."""

    def __init__(self) -> None:
        super().__init__("cartesian_feedback")
        self._axes = declare_settings(self, NodeSettings).axes
        self._settings = declare_settings(self, FeedbackSettings)
        self._robot_clock = StreamClock(self._end, max_gap=_MAX_GAP)
        self._tip: Array | None = None
        self._integrator: GoalIntegrator | None = None
        self._mode = ""
        self._stopped = False
        self._began = 0  # robot time [ns]
        self._number = 0  # of the goal, given by the learner
        self._goals_set = 0  # by the learner's newest status
        self._targets = self.create_publisher(PointStamped, "target", CONTROL_QOS)
        self.subscribe_stream(PoseStamped, "tip", self._take_tip)
        self.create_subscription(LearningStatus, "learning_status", self._take_status, 10)
        self.create_subscription(Bool, "emergency_stop_active", self._take_stop, LATCHED_QOS)
        # Apart from the services: one of them waits for the learner's answer.
        self._calls = ReentrantCallbackGroup()
        self._learner = self.create_client(SetGoal, "learner/set_goal", callback_group=self._calls)
        self._goals = GoalServer(
            self,
            Mover(
                begin=self._begin,
                current=lambda: self._integrator,
                number=lambda: self._number,
                halt=self._end,
                tip=lambda _: self._tip,
                success=lambda integrator: integrator.arrived if integrator.done else None,
                arrived="arrived",
                late="not there within the time",
                ended="ended by another goal, the learner, or an emergency stop",
            ),
        )

    def _take_tip(self, stamp: int, tip: Array) -> None:
        self._robot_clock.advance(stamp)
        self._tip = tip
        integrator = self._integrator
        if integrator is None:
            return
        target = integrator.update(stamp * 1e-9, tip)
        self._targets.publish(point_message(stamp, target))
        if self._goals.awaited and integrator.done:
            self._end()

    def _take_status(self, message: LearningStatus) -> None:
        self._mode = message.mode
        refuses = message.mode not in _ACCEPTING
        if refuses and nanoseconds(message.header.stamp) > self._began:
            self._end()
        begun_anew = message.goals_set < self._goals_set  # the learner: it knows of no goal
        self._goals_set = message.goals_set
        if begun_anew or message.goals_set > self._number:  # by somebody else
            self._end()

    def _take_stop(self, message: Bool) -> None:
        self._stopped = bool(message.data)
        if self._stopped:
            self._end()

    def _end(self) -> None:
        """Stop to move the target; the learner holds the last one."""
        self._integrator = None
        self._goals.settle()

    async def _begin(self, goal: PointStamped, tolerance: float, timeout: float) -> GoalIntegrator:
        point = goal_from(goal)
        for name, value in (("tolerance", tolerance), ("timeout", timeout)):
            if not (np.isfinite(value) and value >= 0.0):
                raise MessageError(f"{name} must be 0 or above, got {value}")
        if self._robot_clock.now is None:
            raise MessageError("no tip was seen yet: is the tracker running?")
        if not self._mode:
            raise MessageError("no learning_status was seen yet: is the learner running?")
        number = await self._go_feedforward(goal)
        if self._stopped or self._mode == LearningStatus.STOPPED:  # the learner may hear first
            raise MessageError("ended by an emergency stop")
        if self._mode not in _ACCEPTING:
            raise MessageError(f"the learner accepts no targets now: its mode is {self._mode}")
        self._end()
        self._number = number
        self._began = self._robot_clock.now
        self._integrator = GoalIntegrator(
            self._settings,
            point,
            axes=self._axes,
            start=self._robot_clock.now * 1e-9,
            tolerance=tolerance,
            timeout=timeout,
        )
        return self._integrator

    async def _go_feedforward(self, goal: PointStamped) -> int:
        """Let the learner begin the movement: it alone knows which goals it can be given.

        Returns the number that the learner has given to the goal.
        """
        if not self._learner.service_is_ready():
            raise MessageError("the learner's set_goal is not there: is the learner running?")
        answered = Future()

        def end(future: Future | None = None) -> None:
            if not answered.done():
                answered.set_result(None if future is None else future.result())

        timer = self.create_timer(
            _LEARNER_TIMEOUT, end, callback_group=self._calls, clock=self.steady_clock
        )
        self._learner.call_async(SetGoal.Request(goal=goal)).add_done_callback(end)
        answer = await answered
        self.destroy_timer(timer)
        if answer is None:
            raise MessageError(f"the learner did not answer within {_LEARNER_TIMEOUT:g} s")
        if not answer.accepted:
            raise MessageError(answer.message)
        return int(answer.number)

    def diagnose(self) -> tuple[bytes, str, dict[str, str]]:
        """Tell what the feedback does."""
        if self._robot_clock.now is None:
            return WARN, "no tip yet", {}
        if not self._mode:
            return WARN, "no learning_status yet", {}
        integrator = self._integrator
        if integrator is None:
            return OK, "idle", {}
        return OK, "following a goal", {"error [m]": f"{integrator.error:.4f}"}


def main() -> None:
    """Run the Cartesian feedback."""
    exit_with(run(CartesianFeedback))


if __name__ == "__main__":
    main()
