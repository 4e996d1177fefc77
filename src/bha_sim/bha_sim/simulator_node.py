"""The simulated robot as a node: pressures in, lengths, pressures, tip and time out."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
from bha_interfaces.msg import Pressures
from bha_interfaces.srv import Reset
from geometry_msgs.msg import PoseStamped
from numpy.typing import NDArray
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from std_srvs.srv import SetBool, Trigger

from bha_common.command_gate import CommandGate, SafetySettings
from bha_common.ros_messages import stamp_message, tip_message
from bha_common.ros_node import CONTROL_QOS, ERROR, LATCHED_QOS, OK, WARN, BhaNode, exit_with, run
from bha_common.ros_parameters import declare_settings
from bha_common.ros_wire import encode_lengths, encode_pressures
from bha_common.stamps import check_command_stamp
from bha_sim.disturbances import Disturbances
from bha_sim.errors import PlantDivergedError
from bha_sim.lockstep import Pace, PaceSettings
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters
from bha_sim.simulator_settings import SimulatorSettings

Array = NDArray[np.float64]


class Simulator(BhaNode):
    """Steps the plant and publishes what its sensors tell."""

    def __init__(self) -> None:
        super().__init__("simulator")
        self._settings = declare_settings(self, SimulatorSettings)
        pace = declare_settings(self, PaceSettings)
        safety = declare_settings(self, SafetySettings)
        path = self._settings.robot_file
        robot = draw_robot(load_parameters(Path(path) if path else None), self._settings.robot_seed)
        period = self._settings.control_period
        self._plant = Plant(robot, seed=self._settings.robot_seed, control_period=period)
        self._plant.disturb(
            declare_settings(self, Disturbances, "disturbances.", on_change=self._disturb)
        )
        self._gate = CommandGate(safety)
        self._pace = Pace(pace, period, time.monotonic())
        self._period_ns = round(period * 1e9)
        self._tip_period_ns = round(self._settings.tip_period * 1e9)
        self._tick = 0
        self._published = False
        self._answered = False
        self._paused = self._settings.start_paused
        self._diverged = ""
        self._wall_start, self._tick_start = time.monotonic(), 0

        self._lengths = self.create_publisher(JointState, "lengths", CONTROL_QOS)
        self._pressures = self.create_publisher(Pressures, "pressures", CONTROL_QOS)
        self._tip = self.create_publisher(PoseStamped, "tip", CONTROL_QOS)
        self._clock_topic = self.create_publisher(Clock, "/clock", CONTROL_QOS)
        self._stopped = self.create_publisher(Bool, "emergency_stop_active", LATCHED_QOS)
        self._stopped.publish(Bool(data=False))
        self.subscribe_stream(Pressures, "pressure_command", self._take_command)
        self.create_service(Reset, "~/reset", self._reset)
        self.create_service(SetBool, "~/pause", self._pause)
        self.create_service(Trigger, "emergency_stop", self._stop)
        self.create_service(Trigger, "emergency_stop_reset", self._reset_stop)

    @property
    def _now(self) -> int:
        """Simulated time [ns]; it starts one period after 0, since a stamp of 0 is no stamp."""
        return (self._tick + 1) * self._period_ns

    def work(self) -> float:
        """Publish the present state once, and step on when that is due."""
        if self._paused or self._diverged:
            return 1.0
        if not self._published:
            self._publish()
        wait = self._pace.wait(time.monotonic(), self._answered)
        if wait > 0.0:
            return wait
        self._step()
        if self._diverged:
            return 1.0
        # At once: another look at the streams in between would cost lockstep a tenth.
        self._publish()
        return max(0.0, self._pace.wait(time.monotonic(), self._answered))

    def _publish(self) -> None:
        state, now = self._plant.state, self._now
        if now % self._tip_period_ns == 0:
            self._clock_topic.publish(Clock(clock=stamp_message(now)))
            self._tip.publish(tip_message(now, state.tip, state.tip_quaternion))
            self._pressures.publish(encode_pressures(now, state.pressures))
        # Last, so that who answers the lengths has the tip of the same time already.
        self._lengths.publish(encode_lengths(now, state.lengths))
        self._published, self._answered = True, False
        self._pace.published(time.monotonic())

    def _step(self) -> None:
        pressures = self._gate.pressures(self._now * 1e-9, self._settings.control_period)
        try:
            self._plant.step(pressures)
        except PlantDivergedError as error:
            self._diverged = str(error)
            self.get_logger().error(f"{error}; call ~/reset to start a fresh robot")
            return
        self._tick += 1
        self._published = False

    def _take_command(self, stamp: int, pressures: Array) -> None:
        check_command_stamp(stamp, self._now, self._settings.max_command_age)
        self._gate.offer(stamp * 1e-9, pressures)
        if stamp == self._now and self._published:
            self._answered = True
            self._pace.answered()

    def _disturb(self, disturbances: Disturbances) -> None:
        self._plant.disturb(disturbances)
        self.get_logger().info(f"disturbances: {disturbances}")

    def _reset(self, request: Reset.Request, response: Reset.Response) -> Reset.Response:
        self._gate.begin_anew(self._now * 1e-9)
        self._plant.reset(int(request.seed) if request.use_seed else None)
        self._diverged = ""
        self._tick += 1
        self._published = False
        response.success, response.message = True, "a fresh robot, vented and at rest"
        return response

    def _pause(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._paused = bool(request.data)
        if not self._paused:
            self._pace.resume(time.monotonic())
        response.success, response.message = True, "paused" if self._paused else "running"
        return response

    def _stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._gate.stop()
        self._stopped.publish(Bool(data=True))
        self.get_logger().warning("emergency stop")
        response.success = True
        response.message = "stopped; call emergency_stop_reset to end the stop"
        return response

    def _reset_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if not self._gate.stopped:
            response.success, response.message = True, "the emergency stop was not active"
            return response
        self._gate.reset_stop(self._now * 1e-9)
        self._stopped.publish(Bool(data=False))
        response.success = True
        response.message = "the stop has ended; the robot waits for a new command"
        return response

    def diagnose(self) -> tuple[bytes, str, dict[str, str]]:
        """Tell the robot's state and the pace it really has."""
        wall = time.monotonic()
        ticks, seconds = self._tick - self._tick_start, wall - self._wall_start
        self._tick_start, self._wall_start = self._tick, wall
        factor = ticks * self._settings.control_period / max(seconds, 1e-6)
        values = {
            "state": self._gate.state,
            "simulated time [s]": f"{self._now * 1e-9:.2f}",
            "real-time factor": f"{factor:.1f}",
            "lockstep": str(self._pace.in_step),
            "lockstep timeouts": str(self._pace.timeouts),
            "disturbances": str(self._plant.disturbances),
        }
        if self._diverged:
            return ERROR, self._diverged, values
        if self._paused:
            return OK, "paused", values
        if self._gate.state == CommandGate.RUNNING:
            return OK, "running", values
        reason = {
            CommandGate.STOPPED: "emergency stop: safe state",
            CommandGate.SILENT: "no valid pressure_command in time: safe state",
        }
        return WARN, reason[self._gate.state], values


def main() -> None:
    """Run the simulator."""
    exit_with(run(Simulator))


if __name__ == "__main__":
    main()
