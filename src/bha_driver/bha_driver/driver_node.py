"""The pneumatic robot as a node, in place of the simulator: pressures in, lengths out."""

from __future__ import annotations

import time

import numpy as np
from bha_interfaces.msg import Pressures
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from bha_common.command_gate import SafetySettings
from bha_common.ros_lifecycle import (
    ACTIVE,
    FAILURE,
    INACTIVE,
    SUCCESS,
    LifecycleState,
    ManagedNode,
)
from bha_common.ros_node import CONTROL_QOS, ERROR, LATCHED_QOS, OK, WARN, exit_with, run
from bha_common.ros_parameters import declare_settings
from bha_common.ros_wire import encode_lengths, encode_pressures
from bha_common.stamps import check_command_stamp
from bha_driver.autostart import Autostart
from bha_driver.control_cycle import ControlCycle
from bha_driver.cycle_schedule import CycleSchedule
from bha_driver.driver_settings import DriverSettings
from bha_driver.errors import DriverError
from bha_driver.latched_faults import EMERGENCY_STOP
from bha_driver.robot_time import RobotTime
from bha_driver.safety import Safety

Array = NDArray[np.float64]


class Driver(ManagedNode):
    """Reads the terminal at every cycle, and writes to it once it is active."""

    def __init__(self) -> None:
        super().__init__("driver")
        self._settings = declare_settings(self, DriverSettings)
        self._map = self._settings.terminal_map()
        period = self._settings.control_period
        self._safety = Safety(self._map, declare_settings(self, SafetySettings), period)
        self._cycle = ControlCycle(self._map, self._safety)
        self._begin_time()
        self._autostart = Autostart(self._settings.autostart)
        self._told: bool | None = None
        self._told_faults = 0

        self._lengths = self.create_publisher(JointState, "lengths", CONTROL_QOS)
        self._pressures = self.create_publisher(Pressures, "pressures", CONTROL_QOS)
        self._stopped = self.create_publisher(Bool, "emergency_stop_active", LATCHED_QOS)
        self.subscribe_stream(Pressures, "pressure_command", self._take_command)
        self.create_service(Trigger, "emergency_stop", self._stop)
        self.create_service(Trigger, "emergency_stop_reset", self._reset_stop)
        self._tell_stop()

    def on_configure(self, _: LifecycleState) -> object:
        """Connect, read identity and inputs; drive nothing."""
        self._begin_time()
        try:
            reading = self._cycle.open(self._seconds())
        except DriverError as error:
            self.get_logger().error(f"not configured: {error}", throttle_duration_sec=5.0)
            return FAILURE
        lengths = np.round(reading.lengths, 3).tolist()
        self.get_logger().info(f"connected to {self._map.name}; lengths {lengths} m")
        return SUCCESS

    def on_activate(self, _: LifecycleState) -> object:
        """Arm the terminal's watchdog; from now on commands may press."""
        reason = self._cycle.activate(self._seconds())
        if reason:
            self.get_logger().error(f"not activated: {reason}")
        return FAILURE if reason else SUCCESS

    def on_deactivate(self, _: LifecycleState) -> object:
        """Vent; `work` goes on writing until that is done."""
        self._safety.deactivate(self._seconds())
        return SUCCESS

    def on_cleanup(self, _: LifecycleState) -> object:
        """Vent at once, and close the connection."""
        self.close()
        return SUCCESS

    on_shutdown = on_error = on_cleanup

    def close(self) -> None:
        """Vent at once, and close the connection."""
        self._schedule.written()
        self._cycle.close(self._seconds, time.sleep)

    def work(self) -> float:
        """Read when that is due; write when the answer is there, or does not come in time."""
        if self.life_state not in (INACTIVE, ACTIVE):
            self._start_by_itself()
            return 0.1
        now = self._time.now()
        if self._schedule.write_due(now):
            self._write()
        if self._schedule.read_due(now):
            if self._schedule.write_owed:
                self._write()
            self._read(now)
            self._start_by_itself()
        return self._schedule.wait(self._time.now()) * 1e-9

    def _read(self, now: int) -> None:
        tick = self._schedule.begin(now)
        reading = self._cycle.read(self._seconds())
        if reading is not None:
            self._now = tick
            self._pressures.publish(encode_pressures(tick, reading.pressures))
            if reading.plausible:
                self._lengths.publish(encode_lengths(tick, reading.lengths))
        if self._safety.state != "running":
            self._write()  # no answer is waited for
        self._tell_stop()

    def _write(self) -> None:
        self._schedule.written()
        self._cycle.write(self._seconds())
        self._tell_stop()

    def _take_command(self, stamp: int, pressures: Array) -> None:
        check_command_stamp(stamp, self._now or None, self._settings.max_command_age)
        self._safety.offer(stamp * 1e-9, pressures)
        if stamp == self._now and self._schedule.write_owed:
            self._write()

    def _begin_time(self) -> None:
        """Take the system's time anew: it may have been set, back too."""
        self._time = RobotTime()
        self._schedule = CycleSchedule(round(self._settings.control_period * 1e9))
        self._now = 0  # stamp of the newest lengths [ns]

    def _seconds(self) -> float:
        return self._time.now() * 1e-9

    def _start_by_itself(self) -> None:
        step = self._autostart.next_step(self.life_label, time.monotonic())
        if step == "configure":
            self.trigger_configure()
        elif step == "activate":
            self.trigger_activate()

    def _stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._safety.stop(self._seconds())
        self._write()
        response.success = True
        response.message = "stopped; call emergency_stop_reset to end the stop"
        return response

    def _reset_stop(self, _: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        if not self._safety.stopped:
            response.success, response.message = True, "the emergency stop was not active"
            return response
        reason = self._safety.reset(self._seconds())
        response.success = not reason
        response.message = reason or "the stop has ended; the robot waits for a new command"
        self._tell_stop()
        return response

    def _tell_stop(self) -> None:
        """Tell the others of a stop or a fault, and that it has ended."""
        faults = self._safety.faults
        for fault in faults[self._told_faults :]:
            self.get_logger().error(f"safe state: {fault}")
        self._told_faults = len(faults)
        if self._told != self._safety.stopped:
            self._told = self._safety.stopped
            self._stopped.publish(Bool(data=self._told))

    def diagnose(self) -> tuple[bytes, str, dict[str, str]]:
        """Tell the state of the terminal and what is latched."""
        state, faults = self._safety.state, self._safety.faults
        values = {
            "state": state,
            "life cycle": self.life_label,
            "terminal": f"{self._map.name} at {self._map.host}:{self._map.port}",
            "connected": str(self._cycle.connected),
            "failed exchanges": str(self._cycle.failures),
            "missed cycles": str(self._schedule.missed),
            "faults": "; ".join(map(str, faults)) or "none",
        }
        if faults:
            stop_only = all(fault.which == EMERGENCY_STOP for fault in faults)
            return WARN if stop_only else ERROR, f"safe state: {faults[0]}", values
        if self.life_state == INACTIVE and self._safety.trouble:
            return ERROR, f"inactive: drives nothing; {self._safety.trouble}", values
        if state == Safety.INACTIVE:
            return WARN, f"{self.life_label}: drives nothing", values
        if state == "silent":
            return WARN, "no valid pressure_command in time: safe state", values
        return OK, "running", values


def main() -> None:
    """Run the driver."""
    exit_with(run(Driver))


if __name__ == "__main__":
    main()
