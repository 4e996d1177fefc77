"""A driver's core and an emulated terminal with the MuJoCo robot behind it, over real sockets.

Robot time is that of the test: it passes by a period a cycle, however long that takes, so what is
asserted in it does not depend on the machine. Requests and their timeouts are real.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from bha_common.command_gate import SafetySettings
from bha_driver.control_cycle import ControlCycle
from bha_driver.safety import Safety
from bha_driver.scaling import Scaling
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.terminal_file import load_terminal
from bha_driver.terminal_map import Timeouts
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters

PERIOD = 0.02
_LOADED = load_terminal()
MAP = dataclasses.replace(
    _LOADED,
    timeouts=Timeouts(request=0.05, connect=0.25, link=0.1, reconnect=0.5),
    watchdog=dataclasses.replace(_LOADED.watchdog, time=0.2),
)
_PLANTS: list[Plant] = []


def plant() -> Plant:
    """Robot 0, fresh; it is built once, for that takes long."""
    if not _PLANTS:
        _PLANTS.append(Plant(draw_robot(load_parameters(), 0), seed=0))
    _PLANTS[0].reset()
    return _PLANTS[0]


class TerminalBench:
    """Driver core and terminal; a context manager.

    Parameters
    ----------
    terminal : The terminal's map.
    period : Time between two cycles [s].
    """

    def __init__(self, terminal=MAP, period: float = PERIOD) -> None:
        self.time, self.period = 1000.0, period
        self.emulator = TerminalEmulator(terminal, plant(), clock=lambda: self.time)
        self.emulator.delay = 2.0 * terminal.timeouts.request
        self.terminal = terminal
        self.scaling = Scaling(terminal)
        self.rng = np.random.default_rng(0)
        self.command = np.full(9, 6e4)
        self.commanding = True

    def __enter__(self) -> TerminalBench:
        self.emulator.__enter__()
        address = dataclasses.replace(self.terminal, port=self.emulator.port)
        self.safety = Safety(address, SafetySettings(), self.period)
        self.driver = ControlCycle(address, self.safety)
        return self

    def __exit__(self, *_: object) -> None:
        self.driver.close(lambda: self.time, self._pass)
        self.emulator.close()

    def _pass(self, duration: float) -> None:
        self.time += duration

    def start(self) -> TerminalBench:
        """Configure and activate."""
        self.driver.open(self.time)
        assert self.driver.activate(self.time) == ""
        return self

    def cycle(self) -> None:
        """One cycle of robot and driver, with a command that moves now and then."""
        self._pass(self.period)
        self.emulator.step()
        if self.rng.random() < 0.04:
            self.command = self.rng.uniform(3e4, 1.0e5, 9)
        self.driver.read(self.time)
        if self.commanding:
            self.safety.offer(self.time, self.command)
        self.driver.write(self.time)

    def run(self, duration: float) -> None:
        """Let robot time pass [s]."""
        for _ in range(round(duration / self.period)):
            self.cycle()

    def until(self, condition: Callable[[], bool], limit: float) -> float:
        """Go on until a condition holds; the robot time that took [s]."""
        begin = self.time
        while not condition():
            assert self.time - begin < limit, f"not within {limit} s of robot time"
            self.cycle()
        return self.time - begin

    def falls(self) -> Callable[[], bool]:
        """Tell whether the terminal holds less than now, and no bellows holds more."""
        before = self.outputs
        return lambda: bool(
            self.outputs.sum() < before.sum() and (self.outputs <= before + 1e-6).all()
        )

    def measure_wrong(self, length: float) -> None:
        """Let the terminal measure a length [m] of one bellows that is not so."""
        channel = self.terminal.bellows[4].length
        self.emulator.begin("freeze")
        self.emulator.registers.write(channel.register, [channel.word(length)])

    @property
    def outputs(self) -> np.ndarray:
        """Pressures that the terminal holds [Pa], shape (9,)."""
        return self.scaling.commanded(np.array(self.emulator.registers.outputs))
