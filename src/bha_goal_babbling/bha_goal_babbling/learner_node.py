"""The learner as a node: lengths and tip in, one length command every command period out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from bha_interfaces.action import Babble
from bha_interfaces.msg import LearningStatus
from geometry_msgs.msg import PointStamped, PoseStamped
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from bha_common.ros_goals import GoalServer, Mover
from bha_common.ros_messages import (
    MessageError,
    check_measured_lengths,
    goal_from,
    plain_point,
    stamp_message,
)
from bha_common.ros_model_files import ModelFiles, ModelRefusedError
from bha_common.ros_node import CONTROL_QOS, LATCHED_QOS, OK, WARN, BhaNode, exit_with, run
from bha_common.ros_parameters import declare_settings
from bha_common.ros_wire import encode_lengths
from bha_common.settings import check_settings, setting
from bha_common.stamps import StreamClock, check_command_stamp
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbling_session import BabblingSession
from bha_goal_babbling.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from bha_goal_babbling.command_timing import TIP_LOST, CommandTiming
from bha_goal_babbling.learner import Learner, RefusedError
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.observation_window import LONGEST_WAIT
from bha_goal_babbling.reach import Reach
from bha_goal_babbling.task import find_task
from bha_goal_babbling.warm_up import warm_up

_MAX_GAP = 2.0  # [s] between two states; more is doubted


@dataclass(frozen=True)
class NodeSettings:
    """What belongs to the node rather than to learning."""

    robot: str = setting("bha", "Name of the robot; models of other robots are refused")
    task: str = setting("2d", "What is learned: 2d, 3d, or the path of a task file")
    model_file: str = setting("", "Checkpoint to load at the start and to write to")
    checkpoint_period: float = setting(
        60.0, "Exploration time between two checkpoints [s]", low=1.0
    )
    tip_timeout: float = setting(
        0.25,
        "Robot time to wait for the tip of a command period [s]",
        low=0.0,
        high=LONGEST_WAIT,
    )
    max_age: float = setting(1.0, "Age at which a tip or a target is dropped [s]", low=0.02)

    def __post_init__(self) -> None:
        check_settings(self)


class LearnerNode(BhaNode):
    """Commands lengths in every mode; babbles and reaches when asked to."""

    def __init__(self) -> None:
        super().__init__("learner")
        self._settings = declare_settings(self, NodeSettings)
        settings = declare_settings(self, LearnerSettings)
        task = find_task(self._settings.task)
        self._learner = Learner(settings, task)
        self._files = ModelFiles(
            self, self._settings.model_file, self._write_model, self._read_model
        )
        self._files.load_at_start()
        self._robot_clock = StreamClock(self._robot_restarted, max_gap=_MAX_GAP)
        self._timing = CommandTiming(settings.command_period, self._settings.tip_timeout)
        self._saved_at = self._learner.exploration_time
        self._babbled: Future | None = None
        self._begun: tuple[BabblingSession, Future] | None = None

        self._commands = self.create_publisher(JointState, "length_command", CONTROL_QOS)
        self._status = self.create_publisher(LearningStatus, "learning_status", CONTROL_QOS)
        self.subscribe_stream(PoseStamped, "tip", self._take_tip)
        self.subscribe_stream(JointState, "lengths", self._take_lengths)
        self.subscribe_stream(PointStamped, "target", self._take_target)
        self.create_subscription(Bool, "emergency_stop_active", self._take_stop, LATCHED_QOS)
        self._goals = GoalServer(
            self,
            Mover(
                begin=self._begin_reach,
                current=lambda: self._learner.reach,
                number=lambda: self._learner.goals_set,
                halt=self._halt,
                tip=lambda reach: reach.tip,
                success=lambda reach: None if reach.result is None else reach.result.settled,
                arrived="at rest",
                late="not at rest within the time",
                ended="ended by another goal, a target, or an emergency stop",
            ),
        )
        self._babble_action = ActionServer(
            self,
            Babble,
            "~/babble",
            self._babble,
            goal_callback=self._accept_babble,
            handle_accepted_callback=self._begin_babble,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )
        warm_up(task)  # while the others find this node

    def _take_lengths(self, stamp: int, lengths: FloatArray) -> None:
        check_measured_lengths(lengths)
        before = self._robot_clock.now
        self._robot_clock.advance(stamp)
        self._learner.see_lengths(stamp, lengths)
        self._command_if_ready(stamp)  # one that has waited for its tip
        self._timing.advance(before, stamp)
        self._command_if_ready(stamp)

    def _take_tip(self, stamp: int, tip: FloatArray) -> None:
        if self._robot_clock.now is None:
            return  # of no use before the first lengths
        check_command_stamp(stamp, self._robot_clock.now, self._settings.max_age)
        newest = self._learner.newest_tip
        if newest is not None and stamp <= newest:
            raise MessageError(f"stamp {stamp * 1e-9:.3f} s is not newer than the last one")
        self._learner.see_tip(stamp, tip)
        self._command_if_ready(self._robot_clock.now or stamp)

    def _command_if_ready(self, now: int) -> None:
        due = self._timing.take(now, self._learner.newest_tip)
        if due is None:
            return
        lengths = self._learner.update(due)
        if lengths is not None:
            self._commands.publish(encode_lengths(due, lengths))
            self._status.publish(self._status_message(due))
        self._settle_actions()

    def _settle_actions(self) -> None:
        learner = self._learner
        if learner.exploration_time - self._saved_at >= self._settings.checkpoint_period:
            self._checkpoint()
        if learner.session is None and self._babbled is not None:
            self._checkpoint()
            self._babbled.set_result(None)
            self._babbled = None
        if learner.reach is None:
            self._goals.settle()

    def _take_target(self, stamp: int, target: FloatArray) -> None:
        check_command_stamp(stamp, self._robot_clock.now, self._settings.max_age)
        reach = self._learner.reach
        if reach is not None and not np.array_equal(self._learner.task.outcome(target), reach.goal):
            raise MessageError("a goal that was set goes before targets until the tip is there")
        try:
            self._learner.follow(target)
        except RefusedError as error:
            raise MessageError(str(error)) from error

    def _take_stop(self, message: Bool) -> None:
        self._learner.stop(bool(message.data))
        self._settle_actions()

    def _robot_restarted(self) -> None:
        self.get_logger().warning("the robot's time has begun anew: holding where it is")
        self._learner.robot_restarted()
        self._timing.forget()
        self._settle_actions()

    def _halt(self) -> None:
        self._learner.halt()
        self._settle_actions()

    async def _begin_reach(self, goal: PointStamped, tolerance: float, timeout: float) -> Reach:
        try:
            return self._learner.go_to(goal_from(goal), tolerance, timeout)
        except RefusedError as error:
            raise MessageError(str(error)) from error

    def _accept_babble(self, goal: Babble.Goal) -> GoalResponse:
        reason = self._learner.why_not_babble(goal.duration)
        if reason:
            self.get_logger().warning(f"babbling refused: {reason}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _begin_babble(self, handle: ServerGoalHandle) -> None:
        """Begin with the acceptance: `_babble` comes a round later, and the robot moves on."""
        request = handle.request
        session = self._learner.babble(request.duration, restart=request.restart)
        self._babbled = Future()
        self._begun = session, self._babbled
        self._saved_at = self._learner.exploration_time
        handle.execute()

    async def _babble(self, handle: ServerGoalHandle) -> Babble.Result:
        assert self._begun is not None
        session, done = self._begun

        def tell() -> None:
            if handle.is_cancel_requested and self._learner.session is session:
                self._halt()
            else:
                status = self._status_message(self._robot_clock.now or 0)
                handle.publish_feedback(Babble.Feedback(status=status, elapsed=session.elapsed))

        await self.with_progress(done, tell)
        result = Babble.Result()
        result.status = self._status_message(self._robot_clock.now or 0)
        if handle.is_cancel_requested:
            result.message = "cancelled; everything learned so far is kept"
            handle.canceled()
        elif session.done and session.samples:
            result.success, result.message = True, f"explored for {session.elapsed:.0f} s"
            handle.succeed()
        else:
            result.message = self._learner.failure or "ended by an emergency stop or a new robot"
            handle.abort()
        return result

    def _status_message(self, stamp: int) -> LearningStatus:
        babbler = self._learner.babbler
        message = LearningStatus(
            mode=self._learner.mode,
            task=self._learner.task.name,
            exploration_time=self._learner.exploration_time,
            recent_error=float("nan"),
            goals_set=self._learner.goals_set,
            goal=plain_point(self._learner.goal),
        )
        message.header.stamp = stamp_message(stamp)
        if babbler is not None:
            message.movements, message.samples = babbler.movements, babbler.samples
            message.local_models = babbler.local_maps
            message.recent_error = babbler.recent_error
        return message

    def _write_model(self, path: str) -> None:
        learner = self._learner
        if learner.babbler is None:
            raise ModelRefusedError("nothing is learned yet: babble first")
        checkpoint = Checkpoint(learner.babbler, learner.task.name, learner.exploration_time)
        save_checkpoint(path, checkpoint, robot=self._settings.robot)

    def _read_model(self, path: str) -> None:
        stored = load_checkpoint(path, robot=self._settings.robot, task=self._learner.task.name)
        try:
            self._learner.use(stored.babbler, stored.exploration_time)
        except RefusedError as error:
            raise ModelRefusedError(str(error)) from error

    def _checkpoint(self) -> None:
        self._saved_at = self._learner.exploration_time
        self._files.keep()

    def diagnose(self) -> tuple[bytes, str, dict[str, str]]:
        """Tell what the learner does and how far it has come."""
        learner = self._learner
        values = {
            "mode": learner.mode,
            "task": learner.task.name,
            "exploration time [s]": f"{learner.exploration_time:.0f}",
            "movements": str(learner.babbler.movements if learner.babbler else 0),
            "examples in use": str(learner.practised),
        }
        now, tip = self._robot_clock.now, learner.newest_tip
        if now is None:
            return WARN, "no lengths yet", values
        if tip is None or now - tip > TIP_LOST:
            return WARN, "no tip: babbling waits, and errors cannot be told", values
        if learner.failure:
            return WARN, learner.failure, values
        return OK, learner.mode, values

    def close(self) -> None:
        """Keep what was learned."""
        self._checkpoint()


def main() -> None:
    """Run the learner."""
    exit_with(run(LearnerNode))


if __name__ == "__main__":
    main()
