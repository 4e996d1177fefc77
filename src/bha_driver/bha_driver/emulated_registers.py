"""The inside of an emulated terminal: registers, watchdog, and a plant behind them."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_driver.exchange_timing import ExchangeTiming
from bha_driver.scaling import Scaling
from bha_driver.terminal_map import TerminalMap

Array = NDArray[np.float64]


class PlantState(Protocol):
    """What a plant tells: measured lengths [m] and pressures [Pa], shape (9,) each."""

    @property
    def lengths(self) -> Array:
        """Measured lengths [m], shape (9,)."""

    @property
    def pressures(self) -> Array:
        """Measured pressures [Pa], shape (9,)."""


class EmulatedPlant(Protocol):
    """A robot that takes pressures [Pa], shape (9,), for one period at a time."""

    @property
    def state(self) -> PlantState:
        """What can be seen of it now."""

    def step(self, pressures: Array) -> PlantState:
        """Apply pressures [Pa], shape (9,), for one period."""


class EmulatedRegisters:
    """Registers as a terminal has them; may be used from several threads.

    Parameters
    ----------
    terminal : The terminal's map.
    plant : What the valves drive and the potentiometers measure.
    clock : Tells the time of the terminal's watchdog [s].
    """

    def __init__(
        self, terminal: TerminalMap, plant: EmulatedPlant, clock: Callable[[], float]
    ) -> None:
        self._map, self._plant, self._clock = terminal, plant, clock
        self._scaling = Scaling(terminal)
        self._lock = threading.Lock()
        self._first_output, self._outputs_count = terminal.output_block
        self._first_input, self._inputs_count = terminal.input_block
        self._registers: dict[int, int] = {}
        self._fed = clock()
        self.frozen = False
        self.timing = ExchangeTiming()
        self.trips = 0
        """How often the watchdog has vented."""
        self._written: deque[tuple[float, tuple[int, ...]]] = deque(maxlen=100_000)
        self.boot()

    @property
    def addresses(self) -> set[int]:
        """All registers that there are."""
        return set(self._registers)

    @property
    def outputs(self) -> tuple[int, ...]:
        """The words of the set-points."""
        with self._lock:
            return self._row(self._first_output, self._outputs_count)

    @property
    def writes(self) -> list[tuple[float, tuple[int, ...]]]:
        """When set-points were written [s], and which words; the newest last."""
        with self._lock:
            return list(self._written)

    def forget_writes(self) -> None:
        """Empty `writes`."""
        with self._lock:
            self._written.clear()

    @property
    def armed(self) -> bool:
        """Whether the watchdog watches."""
        register = self._map.watchdog.register
        return register is None or self._registers[register] > 0

    def boot(self) -> None:
        """Begin as after power-up: vented, the watchdog off."""
        with self._lock:
            self._put(self._first_input, [0] * self._inputs_count)
            self._put(self._first_output, self._scaling.vented.tolist())
            if self._map.identity is not None:
                self._put(self._map.identity.register, list(self._map.identity.words))
            if self._map.watchdog.register is not None:
                self._registers[self._map.watchdog.register] = 0
            self._fed = self._clock()
            self._refresh()

    def read(self, register: int, count: int) -> list[int]:
        """Read registers that are there."""
        with self._lock:
            if register <= self._first_input < register + count:
                self.timing.read(self._clock())
            return list(self._row(register, count))

    def write(self, register: int, words: list[int]) -> None:
        """Write registers that are there; set-points feed the watchdog, nothing else does."""
        with self._lock:
            self._watch()  # what comes too late finds the terminal vented
            self._put(register, words)
            if register < self._first_output + self._outputs_count and (
                register + len(words) > self._first_output
            ):
                self._fed = self._clock()
                self.timing.written(self._fed)
                outputs = self._row(self._first_output, self._outputs_count)
                self._written.append((self._fed, outputs))
            elif register == self._map.watchdog.register:
                self._fed = self._clock()

    def step(self) -> None:
        """Let the plant live for one period under the set-points, and measure."""
        with self._lock:
            self._watch()
            words = np.array(self._row(self._first_output, self._outputs_count))
        self._plant.step(self._scaling.commanded(words))
        with self._lock:
            self.timing.stepped()
            self._refresh()

    def watch(self) -> None:
        """Let the watchdog look."""
        with self._lock:
            self._watch()

    def _watch(self) -> None:
        register, watchdog = self._map.watchdog.register, self._map.watchdog
        time = watchdog.time if register is None else self._registers[register] * watchdog.step
        vented = self._scaling.vented.tolist()
        outputs = list(self._row(self._first_output, self._outputs_count))
        if time > 0.0 and self._clock() - self._fed > time and outputs != vented:
            self._put(self._first_output, vented)
            self.trips += 1

    def _refresh(self) -> None:
        if self.frozen:
            return
        state = self._plant.state
        lengths, pressures = state.lengths.tolist(), state.pressures.tolist()
        for index in range(bellows.COUNT):
            channels = self._map.bellows[index]
            self._registers[channels.length.register] = channels.length.word(lengths[index])
            self._registers[channels.pressure.register] = channels.pressure.word(pressures[index])

    def _row(self, register: int, count: int) -> tuple[int, ...]:
        return tuple(self._registers[register + index] for index in range(count))

    def _put(self, register: int, words: list[int]) -> None:
        for index, word in enumerate(words):
            self._registers[register + index] = word
