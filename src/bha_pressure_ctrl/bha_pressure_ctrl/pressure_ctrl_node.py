"""The pressure controller as a node: lengths and length commands in, pressures out."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from bha_interfaces.action import Identify
from bha_interfaces.msg import Pressures
from numpy.typing import NDArray
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool

from bha_common.ros_messages import check_measured_lengths
from bha_common.ros_model_files import ModelFiles, ModelRefusedError
from bha_common.ros_node import CONTROL_QOS, LATCHED_QOS, OK, WARN, BhaNode, exit_with, run
from bha_common.ros_parameters import declare_settings
from bha_common.ros_wire import encode_pressures
from bha_common.settings import check_settings, setting
from bha_common.stamps import StreamClock, check_command_stamp
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel, EquilibriumModelError
from bha_pressure_ctrl.model_fitting import MIN_SAMPLES
from bha_pressure_ctrl.pressure_control import PressureControl, PressureControlSettings

Array = NDArray[np.float64]
_MAX_GAP = 2.0  # [s] between two states; more is doubted


@dataclass(frozen=True)
class NodeSettings:
    """What belongs to the node rather than to the control."""

    robot: str = setting("bha", "Name of the robot; models of other robots are refused")
    model_file: str = setting("", "Equilibrium model to load at the start and to save to")
    command_period: float = setting(
        0.5, "Time between two length commands [s]; a multiple of the control period", low=0.02
    )
    max_command_age: float = setting(1.0, "Age at which a length command is dropped [s]", low=0.02)
    lockstep: bool = setting(
        False, "Wait for the length command of each command period before answering its state"
    )
    lockstep_timeout: float = setting(
        2.0, "Wall time after which a wait for a length command ends [s]", low=0.01
    )

    def __post_init__(self) -> None:
        check_settings(self)


class PressureCtrl(BhaNode):
    """Answers every state of the robot with pressures."""

    def __init__(self) -> None:
        super().__init__("pressure_ctrl")
        self._settings = declare_settings(self, NodeSettings)
        self._control = PressureControl(declare_settings(self, PressureControlSettings))
        self._robot_clock = StreamClock(self._robot_restarted, max_gap=_MAX_GAP)
        self._period_ns = round(self._settings.command_period * 1e9)
        self._commanded = 0  # stamp of the newest length command [ns]
        self._commander_alive: bool | None = None  # None: it had no turn yet
        self._held: tuple[int, Array] | None = None  # a state that waits for its command
        self._held_until = 0.0
        self._identified: Future | None = None
        files = ModelFiles(self, self._settings.model_file, self._write_model, self._read_model)
        if not files.load_at_start():
            self.get_logger().warning(
                "no equilibrium model yet: venting until ~/identify is called"
            )

        self._pressures = self.create_publisher(Pressures, "pressure_command", CONTROL_QOS)
        self.subscribe_stream(JointState, "length_command", self._take_command)
        self._command_topic = self.resolve_topic_name("length_command")
        self.subscribe_stream(JointState, "lengths", self._take_lengths)
        self.create_subscription(Bool, "emergency_stop_active", self._take_stop, LATCHED_QOS)
        self._action = ActionServer(
            self,
            Identify,
            "~/identify",
            execute_callback=self._identify,
            goal_callback=self._accept_identify,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    def work(self) -> float:
        """End a lockstep wait that lasts too long."""
        if self._held is None:
            return 1.0
        left = self._held_until - time.monotonic()
        if left <= 0.0:
            self._commander_alive = False
            self.get_logger().warning("no length_command in time: going on without lockstep")
            self._answer_held()
        return max(left, 0.0)

    def _take_lengths(self, stamp: int, lengths: Array) -> None:
        check_measured_lengths(lengths)
        self._robot_clock.advance(stamp)
        if self._held is not None:
            self._answer_held()
        due = self._settings.lockstep and stamp % self._period_ns == 0 and self._has_commander()
        self._held = (stamp, lengths)
        if due and self._commanded < stamp:
            self._held_until = time.monotonic() + self._settings.lockstep_timeout
        else:
            self._answer_held()

    def _has_commander(self) -> bool:
        """Tell whether a command will come: from one who sends them, or is there to begin."""
        if self._commander_alive is None:
            return bool(self.count_publishers(self._command_topic) > 0)
        return self._commander_alive

    def _answer_held(self) -> None:
        assert self._held is not None
        (stamp, lengths), self._held = self._held, None
        pressures = self._control.update(stamp * 1e-9, lengths)
        self._pressures.publish(encode_pressures(stamp, pressures))
        self._settle_identify()

    def _settle_identify(self) -> None:
        identification = self._control.identification
        if self._identified is not None and (identification is None or identification.done):
            self._identified.set_result(None)
            self._identified = None

    def _take_command(self, stamp: int, lengths: Array) -> None:
        if self._robot_clock.now is None:
            return  # of no use before the first lengths; diagnostics tell
        check_command_stamp(stamp, self._robot_clock.now, self._settings.max_command_age)
        self._control.command(stamp * 1e-9, lengths)
        self._commanded, self._commander_alive = stamp, True
        if self._held is not None and self._held[0] <= stamp:
            self._answer_held()

    def _take_stop(self, message: Bool) -> None:
        if message.data or self._control.stopped:
            self._control.stop(bool(message.data))

    def _robot_restarted(self) -> None:
        self.get_logger().warning("the robot's time has begun anew: waiting for new commands")
        self._control.begin_anew()
        self._held = None
        self._commanded, self._commander_alive = 0, None

    def _accept_identify(self, goal: Identify.Goal) -> GoalResponse:
        problem = self._why_not_identify(int(goal.samples))
        if problem:
            self.get_logger().warning(f"identification refused: {problem}")
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def _why_not_identify(self, samples: int) -> str:
        if samples and samples < MIN_SAMPLES:
            return f"samples must be 0 or at least {MIN_SAMPLES}, got {samples}"
        if self._control.identification is not None:
            return "identification is running already"
        if self._control.mode == PressureControl.STOPPED:
            return "the emergency stop is active: reset it first"
        return ""

    async def _identify(self, handle: ServerGoalHandle) -> Identify.Result:
        result = Identify.Result()
        try:
            identification = self._control.identify(int(handle.request.samples) or None)
        except RuntimeError as error:
            result.message = str(error)
            handle.abort()
            return result
        self._identified = finished = Future()
        await self.with_progress(finished, lambda: self._tell_progress(handle))
        result.samples = identification.collected
        if handle.is_cancel_requested:
            self._control.abandon_identification()
            result.message = "cancelled; the model in use stays"
            handle.canceled()
            return result
        try:
            model = self._control.finish_identification()
        except (EquilibriumModelError, RuntimeError) as error:
            result.message = f"no model: {error}"
            handle.abort()
            return result
        result.success, result.pressure_error = True, model.pressure_error
        result.message = f"fitted to {model.samples} samples, {model.pressure_error:.0f} Pa error"
        handle.succeed()
        return result

    def _tell_progress(self, handle: ServerGoalHandle) -> None:
        identification = self._control.identification
        if handle.is_cancel_requested:
            self._control.abandon_identification()
            self._settle_identify()
        elif identification is not None:
            handle.publish_feedback(
                Identify.Feedback(
                    collected=identification.collected,
                    requested=identification.requested,
                    elapsed=identification.elapsed,
                )
            )

    def _write_model(self, path: str) -> None:
        model = self._control.model
        if model is None:
            raise ModelRefusedError("there is no model to save: call ~/identify first")
        model.save(path, self._settings.robot)

    def _read_model(self, path: str) -> None:
        self._control.use(EquilibriumModel.load(path, self._settings.robot))

    def diagnose(self) -> tuple[bytes, str, dict[str, str]]:
        """Tell what the controller does and with which model."""
        model, mode = self._control.model, self._control.mode
        values = {
            "mode": mode,
            "model": "none" if model is None else f"{model.samples} samples",
            "commander": "alive" if self._commander_alive else "silent",
        }
        if self._robot_clock.now is None:
            return WARN, "no lengths yet", values
        summary = {
            PressureControl.NO_MODEL: "no equilibrium model: venting; call ~/identify",
            PressureControl.SILENT: "no valid length_command in time: safe state",
            PressureControl.STOPPED: "emergency stop: safe state",
        }.get(mode)
        return (OK, mode, values) if summary is None else (WARN, summary, values)


def main() -> None:
    """Run the pressure controller."""
    exit_with(run(PressureCtrl))


if __name__ == "__main__":
    main()
