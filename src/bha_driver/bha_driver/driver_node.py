"""The pneumatic robot as a node, in place of the simulator: pressures in, lengths out."""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass

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
    UNCONFIGURED,
    LifecycleState,
    ManagedNode,
)
from bha_common.ros_node import CONTROL_QOS, ERROR, LATCHED_QOS, OK, WARN, exit_with, run
from bha_common.ros_parameters import declare_settings
from bha_common.ros_wire import encode_lengths, encode_pressures
from bha_common.settings import check_settings, setting
from bha_common.stamps import check_command_stamp
from bha_driver.control_cycle import ControlCycle, Reading
from bha_driver.errors import DriverError
from bha_driver.robot_time import RobotTime, Ticks
from bha_driver.safety import EMERGENCY_STOP, Safety
from bha_driver.terminal_file import load_terminal

Array = NDArray[np.float64]

_CONFIGURE_AGAIN = 1.0  # [s] between two tries to configure by itself


@dataclass(frozen=True)
class DriverSettings:
    """Which terminal is driven, and how often."""

    terminal: str = setting("", "YAML of the terminal; empty: the emulated one")
    host: str = setting("", "Address of the terminal; empty: as the YAML says")
    port: int = setting(0, "TCP port of the terminal; 0: as the YAML says", low=0, high=65535)
    control_period: float = setting(0.02, "Time between two cycles [s]", low=5e-3, high=0.1)
    max_command_age: float = setting(
        0.5, "Age at which a pressure command is dropped [s]", low=0.02
    )
    autostart: str = setting(
        "none", "What it does by itself", choices=("none", "configure", "activate")
    )

    def __post_init__(self) -> None:
        check_settings(self)


class Driver(ManagedNode):
    """Reads the terminal at every cycle, and writes to it once it is active."""

    def __init__(self) -> None:
        super().__init__("driver")
        self._settings = declare_settings(self, DriverSettings)
        terminal = load_terminal(self._settings.terminal or None)
        self._map = dataclasses.replace(
            terminal,
            host=self._settings.host or terminal.host,
            port=self._settings.port or terminal.port,
        )
        period = self._settings.control_period
        self._safety = Safety(self._map, declare_settings(self, SafetySettings), period)
        self._cycle = ControlCycle(self._map, self._safety)
        self._time = RobotTime()
        self._ticks = Ticks(round(period * 1e9))
        self._answer_time = round(0.5 * period * 1e9)
        self._now = 0  # stamp of the newest lengths [ns]
        self._write_due: int | None = None  # when the set-points are written at the latest [ns]
        self._autostart_due = 0.0
        self._told: bool | None = None
        self._told_faults = 0

        self._lengths = self.create_publisher(JointState, "lengths", CONTROL_QOS)
        self._pressures = self.create_publisher(Pressures, "pressures", CONTROL_QOS)
        self._stopped = self.create_publisher(Bool, "emergency_stop_active", LATCHED_QOS)
        self.subscribe_stream(Pressures, "pressure_command", self._take_command)
        self.create_service(Trigger, "emergency_stop", self._stop)
        self.create_service(Trigger, "emergency_stop_reset", self._reset_stop)
        self._tell_stop()

    # --- life cycle ------------------------------------------------------------------------

    def on_configure(self, _: LifecycleState) -> object:
        """Connect, read identity and inputs; drive nothing."""
        self._time = RobotTime()
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

    def on_shutdown(self, _: LifecycleState) -> object:
        """Vent at once, and close the connection."""
        self.close()
        return SUCCESS

    def close(self) -> None:
        """Vent at once, and close the connection."""
        self._write_due = None
        self._cycle.close(self._seconds, time.sleep)

    # --- cycle -----------------------------------------------------------------------------

    def work(self) -> float:
        """Read when that is due; write when the answer is there, or does not come in time."""
        if self.life_state not in (INACTIVE, ACTIVE):
            self._autostart()
            return 0.1
        now = self._time.now()
        if self._write_due is not None and now >= self._write_due:
            self._write()
        wait = self._ticks.wait(now)
        if wait <= 0:
            self._read(self._ticks.take(now))
            self._autostart()
            wait = self._ticks.wait(self._time.now())
        if self._write_due is not None:
            wait = min(wait, self._write_due - self._time.now())
        return max(0.0, wait * 1e-9)

    def _read(self, tick: int) -> None:
        if self._write_due is not None:
            self._write()
        reading = self._cycle.read(self._seconds())
        if reading is not None:
            self._publish(tick, reading)
        self._write_due = tick + self._answer_time
        if self._safety.state != "running":
            self._write()  # no answer is waited for
        self._tell_stop()

    def _publish(self, tick: int, reading: Reading) -> None:
        self._now = tick
        self._pressures.publish(encode_pressures(tick, reading.pressures))
        if reading.plausible:
            self._lengths.publish(encode_lengths(tick, reading.lengths))

    def _write(self) -> None:
        self._write_due = None
        self._cycle.write(self._seconds())
        self._tell_stop()

    def _take_command(self, stamp: int, pressures: Array) -> None:
        check_command_stamp(stamp, self._now or None, self._settings.max_command_age)
        self._safety.offer(stamp * 1e-9, pressures)
        if stamp == self._now and self._write_due is not None:
            self._write()

    def _seconds(self) -> float:
        return self._time.now() * 1e-9

    def _autostart(self) -> None:
        """Configure and activate by itself, if that is wanted, until it has worked once."""
        wanted, now = self._settings.autostart, time.monotonic()
        if self._autostart_due == np.inf or now < self._autostart_due:
            return
        self._autostart_due = now + _CONFIGURE_AGAIN
        if wanted != "none" and self.life_state == UNCONFIGURED:
            self.trigger_configure()
        if wanted == "activate" and self.life_state == INACTIVE:
            self.trigger_activate()
        goal = {"none": UNCONFIGURED, "configure": INACTIVE, "activate": ACTIVE}[wanted]
        if self.life_state == goal:
            self._autostart_due = np.inf

    # --- emergency stop --------------------------------------------------------------------

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
            "missed cycles": str(self._ticks.missed),
            "faults": "; ".join(map(str, faults)) or "none",
        }
        if faults:
            stop_only = all(fault.which == EMERGENCY_STOP for fault in faults)
            return WARN if stop_only else ERROR, f"safe state: {faults[0]}", values
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
