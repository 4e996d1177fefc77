"""The emulated terminal with the MuJoCo robot behind it, and a tracker that publishes `tip`."""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from pathlib import Path

from geometry_msgs.msg import PoseStamped

from bha_common.ros_messages import tip_message
from bha_common.ros_node import CONTROL_QOS, OK, WARN, BhaNode, exit_with, run
from bha_common.ros_parameters import declare_settings
from bha_common.settings import check_settings, setting
from bha_driver.fault_player import FaultPlayer
from bha_driver.robot_time import RobotTime, Ticks
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.terminal_file import load_terminal
from bha_driver.wire_faults import parse_faults
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters

_LEAD = 0.4
"""How long before its time a state is there, in periods.

Driver and robot both count whole periods of the system's time. Were the robot to step at the very
moment at which the driver reads, chance would decide whether a cycle sees the new state or the old
one. With a lead it is read at its time, and answered, halfway to the next one at the latest, before
the robot goes on: as in the simulator. So it must be below a half, and with little to spare, for a
process that wakes up late must be in time all the same.
"""


@dataclass(frozen=True)
class EmulatorSettings:
    """Which terminal and which robot are emulated."""

    terminal: str = setting("", "YAML of the terminal; empty: the emulated one of bha_driver")
    port: int = setting(0, "TCP port to listen on; 0: as the YAML says", low=0, high=65535)
    robot_file: str = setting("", "YAML of the robot's physics; empty: the one of bha_sim")
    robot_seed: int = setting(0, "Draws the individual robot and the noise of its sensors", low=0)
    plant_period: float = setting(
        0.02, "Time between two steps of the robot [s]", low=1e-3, high=0.1
    )
    tip_period: float = setting(
        0.1, "Time between two positions of the tip [s]; multiple of the plant period", low=1e-3
    )
    faults: str = setting("", "Faults to inject, such as: cut@10, delay@20+0.5 [s]")

    def __post_init__(self) -> None:
        check_settings(self)


class EmulatorNode(BhaNode):
    """Lets the robot live by the wall clock; what is sent to its terminal moves it."""

    def __init__(self) -> None:
        super().__init__("terminal_emulator")
        settings = declare_settings(self, EmulatorSettings)
        terminal = load_terminal(settings.terminal or None)
        terminal = dataclasses.replace(terminal, port=settings.port or terminal.port)
        path = settings.robot_file
        robot = draw_robot(load_parameters(Path(path) if path else None), settings.robot_seed)
        self._plant = Plant(robot, seed=settings.robot_seed, control_period=settings.plant_period)
        self._emulator = TerminalEmulator(terminal, self._plant, port=terminal.port)
        self._faults = FaultPlayer(self._emulator, parse_faults(settings.faults))
        self._period = round(settings.plant_period * 1e9)
        self._tip_period = round(settings.tip_period * 1e9)
        self._lead = round(_LEAD * self._period)
        self._time = RobotTime()
        self._ticks = Ticks(self._period)
        self._started = time.monotonic()
        self._stepped: int | None = None
        self._tip = self.create_publisher(PoseStamped, "tip", CONTROL_QOS)
        self._emulator.__enter__()

    def work(self) -> float:
        """Step the robot as often as time has passed for it, and publish its tip."""
        now = self._now
        if self._ticks.wait(now) > 0:
            return self._ticks.wait(now) * 1e-9
        tick = self._ticks.take(now)
        self._faults.advance(time.monotonic() - self._started)
        # A robot does not wait: what was missed is caught up with.
        steps = 1 if self._stepped is None else min((tick - self._stepped) // self._period, 25)
        for _ in range(steps):
            self._emulator.step()
        passed = (
            self._stepped is None or tick // self._tip_period > self._stepped // self._tip_period
        )
        self._stepped = tick
        if passed:
            state = self._plant.state
            stamp = tick // self._tip_period * self._tip_period
            self._tip.publish(tip_message(stamp, state.tip, state.tip_quaternion))
        return max(0.0, self._ticks.wait(self._now) * 1e-9)

    @property
    def _now(self) -> int:
        """The robot's own time [ns], ahead of the driver's."""
        return self._time.now() + self._lead

    def close(self) -> None:
        """End the server, and leave in the log how the exchanges lay between the steps."""
        self._emulator.close()
        timing = self._emulator.registers.timing
        self.get_logger().info(
            f"{timing.cycles} cycles, {timing.late} late writes, {timing.stale} states read twice, "
            f"{timing.skipped} not read; {self._ticks.missed} steps were late"
        )

    def diagnose(self) -> tuple[bytes, str, dict[str, str]]:
        """Tell who is connected and what is wrong on purpose."""
        faults = ", ".join(sorted(self._emulator.faults))
        timing = self._emulator.registers.timing
        values = {
            "port": str(self._emulator.port),
            "connections": str(self._emulator.connections),
            "requests": str(self._emulator.requests),
            "faults": faults or "none",
            "watchdog trips": str(self._emulator.registers.trips),
            "late steps": str(self._ticks.missed),
            "read to write [ms]": f"{timing.median * 1e3:.2f}, at most {timing.longest * 1e3:.2f}",
            "cycles": str(timing.cycles),
            "states read twice": str(timing.stale),
            "states not read": str(timing.skipped),
            "late writes": str(timing.late),
        }
        if faults:
            return WARN, f"injected: {faults}", values
        return OK, "listening", values


def main() -> None:
    """Run the emulated terminal."""
    exit_with(run(EmulatorNode))


if __name__ == "__main__":
    main()
