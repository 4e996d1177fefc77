"""How fast the driver is in its safe state, measured at the terminal, fault by fault.

./bha shell python -m benchmarks.scripts.driver_reaction --repeats 10

A driver's core and an emulated terminal with the limits and times of a lab (cpx_e.yaml) run in
real time over real sockets. For each fault: the time from when it can be known to the first write
that vents, or, where the terminal cannot be reached, to the moment its own watchdog has vented. A
busy machine shows in the longest times.
"""

import argparse
import dataclasses
import time

import numpy as np

from bha_common.command_gate import SafetySettings
from bha_driver.control_cycle import ControlCycle
from bha_driver.safety import Safety
from bha_driver.scaling import Scaling
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.terminal_file import example_path, load_terminal
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters

PERIOD = 0.02
LAB = load_terminal(example_path("cpx_e"))
ROWS = {
    "emergency stop": "the call",
    "command silence": "command_timeout after the last command",
    "length out of range": "the reading",
    "swap": "its begin",
    "freeze": "frozen_time after its begin",
    "cut": "its begin",
    "restart": "its begin",
    "delay": "link time after the last good exchange",
    "drop": "link time after the last good exchange",
    "exception": "link time after the last good exchange",
    "refuse": "its begin",
    "driver killed": "watchdog time after the last write",
}


class RealTime:
    """Driver and terminal by the wall clock."""

    def __init__(self, plant: Plant) -> None:
        plant.reset()
        self.emulator = TerminalEmulator(LAB, plant)
        self.emulator.delay = 0.1
        self.rng = np.random.default_rng(0)
        self.command = np.full(9, 5e4)
        self.commanding = True
        self.driving = True
        self.length_fault = False
        self.scaling = Scaling(LAB)
        self.latched: float | None = None
        self.last_good = 0.0

    def __enter__(self) -> "RealTime":
        self.emulator.__enter__()
        terminal = dataclasses.replace(LAB, host="127.0.0.1", port=self.emulator.port)
        self.safety = Safety(terminal, SafetySettings(), PERIOD)
        self.driver = ControlCycle(terminal, self.safety)
        self.driver.open(time.monotonic())
        reason = self.driver.activate(time.monotonic())
        if reason:
            raise RuntimeError(reason)
        self.due = time.monotonic()
        return self

    def __exit__(self, *_: object) -> None:
        self.driver.close(time.monotonic, time.sleep)
        self.emulator.close()

    def cycle(self) -> None:
        """Wait for the next cycle and do it."""
        self.due = max(self.due + PERIOD, time.monotonic() - PERIOD)
        time.sleep(max(0.0, self.due - time.monotonic()))
        self.emulator.step()
        if not self.driving:
            return
        now = time.monotonic()
        reading = self.driver.read(now)
        if self.commanding:
            if self.rng.random() < 0.1:
                self.command = self.rng.uniform(2e4, 8e4, 9)
            self.safety.offer(time.monotonic(), self.command)
        written = self.driver.write(time.monotonic())
        if reading is not None and written:
            self.last_good = now
        if self.safety.stopped and self.latched is None:
            self.latched = time.monotonic()

    def run(self, duration: float) -> None:
        """Let time pass [s]."""
        end = time.monotonic() + duration
        while time.monotonic() < end:
            self.cycle()


def react(plant: Plant, row: str) -> tuple[float, float]:
    """Let one thing happen; time to the safe state at the terminal, and to the latch [s]."""
    with RealTime(plant) as bench:
        bench.run(1.0)
        registers, emulator = bench.emulator.registers, bench.emulator
        time.sleep(float(np.random.default_rng().uniform(0.0, PERIOD)))
        begin = time.monotonic()
        trips = registers.trips
        known = begin
        if row == "emergency stop":
            bench.safety.stop(begin)
        elif row == "command silence":
            bench.commanding = False
            known = begin + SafetySettings().command_timeout
        elif row == "driver killed":
            bench.driving = False
            known = registers.writes[-1][0] + LAB.watchdog.time
        elif row == "length out of range":
            bad = LAB.bellows[4].length
            emulator.begin("freeze")
            registers.write(bad.register, [bad.word(0.05)])
        else:
            emulator.begin(row)
        if row == "freeze":
            known = begin + LAB.limits.frozen_time
        before = bench.scaling.commanded(np.array(registers.outputs)).sum()
        safe = None
        while safe is None and time.monotonic() < begin + 6.0:
            count = len(registers.writes)
            bench.cycle()
            if registers.trips > trips:
                safe = time.monotonic()
            for moment, words in registers.writes[count:]:
                total = bench.scaling.commanded(np.array(words)).sum()
                vents = bench.safety.state in ("stopped", "silent")
                if safe is None and vents and total < before:
                    safe = moment
                before = total
        if safe is None:
            raise RuntimeError(f"{row}: no safe state within 6 s: {bench.safety.faults}")
        if row in ("delay", "drop", "exception", "refuse", "restart") and registers.trips > trips:
            known = registers.writes[-1][0] + LAB.watchdog.time
        latch = float("nan")
        if bench.latched is not None:
            reach = row in ("delay", "drop", "exception")
            latch = bench.latched - (bench.last_good + LAB.timeouts.link if reach else known)
            if row in ("refuse", "restart"):
                latch = bench.latched - begin
        return safe - known, latch


def main() -> None:
    """Print one line a fault."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=10, help="how often each happens")
    parser.add_argument("--only", choices=list(ROWS), help="this one alone")
    arguments = parser.parse_args()
    plant = Plant(draw_robot(load_parameters(), 0), seed=0)
    print("time to the safe state at the terminal and to the latch in the driver [ms]")
    print(
        f"{'what happens':20s} {'median':>7s} {'longest':>8s} {'latch':>7s} {'longest':>8s}  from"
    )
    for row in [arguments.only] if arguments.only else ROWS:
        times = np.array([react(plant, row) for _ in range(arguments.repeats)]) * 1e3
        latch = "      -        -"
        if np.isfinite(times[:, 1]).any():
            latch = f"{np.nanmedian(times[:, 1]):7.0f} {np.nanmax(times[:, 1]):8.0f}"
        safe = f"{np.median(times[:, 0]):7.0f} {times[:, 0].max():8.0f}"
        print(f"{row:20s} {safe} {latch}  {ROWS[row]}", flush=True)


if __name__ == "__main__":
    main()
