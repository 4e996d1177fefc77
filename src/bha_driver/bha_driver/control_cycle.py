"""One cycle of the driver: read, decide, write; connect again when the terminal is gone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_driver.errors import TerminalError
from bha_driver.safety import Safety
from bha_driver.scaling import Scaling
from bha_driver.terminal import Terminal
from bha_driver.terminal_map import TerminalMap

Array = NDArray[np.float64]

_TRIES = 3
_LONGEST_END = 2.0
"""After so long [s] what is left is vented at once: nodes that take 5 s to end are killed, and each
of two more writes may take a second, the longest `timeouts.request`."""


@dataclass(frozen=True, eq=False)
class Reading:
    """What the terminal measured.

    Attributes
    ----------
    lengths : Bellows lengths [m], shape (9,).
    pressures : Measured pressures [Pa], shape (9,).
    plausible : Whether the lengths can be believed.
    """

    lengths: Array
    pressures: Array
    plausible: bool


class ControlCycle:
    """Moves between a terminal and the safety logic; all times are given to it.

    Parameters
    ----------
    terminal : The terminal's map.
    safety : Decides what is written.
    """

    def __init__(self, terminal: TerminalMap, safety: Safety) -> None:
        self._map = terminal
        self._terminal = Terminal(terminal)
        self._safety = safety
        self._scaling = Scaling(terminal)
        self._retry_at = -np.inf
        self._armed = False
        self._down_since: float | None = None
        self.failures = 0
        """Exchanges that failed since the start; those that `connect` tries again among them."""

    @property
    def connected(self) -> bool:
        """Whether a connection is open, as far as is known."""
        return self._terminal.connected

    def open(self, time: float) -> Reading:
        """Connect, and read once; nothing is written.

        Raises
        ------
        TerminalError
            When that fails.
        """
        self._armed = False
        self._retry_at = -np.inf
        self._safety.begin(time)
        for attempt in range(_TRIES):
            try:
                self._terminal.connect()
                self._safety.link_made(time, intact=False)
                return self._look(time)
            except TerminalError as error:
                self._terminal.close()
                self._safety.link_failed(time, str(error))
                # Nothing is driven yet, so a late answer is no reason to give up.
                if error.gone or attempt == _TRIES - 1:
                    raise
        raise AssertionError("unreachable")

    def activate(self, time: float) -> str:
        """Arm the terminal's watchdog and allow pressing; the reason when not, else empty."""
        if reason := self._safety.refusal():
            return reason
        try:
            held = self._terminal.set_points()
            if held is not None and (reason := self._safety.not_ours(held)):
                return reason
            self._terminal.arm_watchdog()
            self._armed = True
        except TerminalError as error:
            self._fail(time, error)
            return str(error)
        return self._safety.activate(time)

    def read(self, time: float) -> Reading | None:
        """Read all inputs, after connecting again if need be; None when that fails."""
        try:
            if not self._terminal.connected:
                if time < self._retry_at:
                    self._safety.link_failed(time)
                    return None
                self._connect_again(time)
            return self._look(time)
        except TerminalError as error:
            self._fail(time, error)
            return None

    def write(self, time: float, *, ending: bool = False) -> bool:
        """Write the set-points that the safety logic decides on; whether any were written."""
        if not self._terminal.connected:
            return False
        block = self._safety.set_points(time, ending=ending)
        if block is None:
            return False
        try:
            self._terminal.write(block)
        except TerminalError as error:
            self._fail(time, error)
            if self._safety.link_lost and not error.gone:
                # It can be read and not written: where reads feed its watchdog, silence vents.
                self._retry_at = time + 1.5 * self._map.watchdog.time
            return False
        self._safety.confirmed(time)
        return True

    def close(self, clock: Callable[[], float], wait: Callable[[float], None]) -> None:
        """Vent, then close the connection; that takes about 4 s at most.

        A terminal that cannot be reached vents by itself.

        Parameters
        ----------
        clock : Tells the time [s].
        wait : Waits for a time [s].
        """
        begin = clock()
        self._safety.deactivate(begin)
        while self._safety.pressing:
            if clock() - begin >= _LONGEST_END:
                self._safety.vent_at_once()
            if not self.write(clock(), ending=True):
                break
            wait(self._safety.period)
        self._terminal.close()
        self._safety.link_failed(clock(), "closed")

    def _look(self, time: float) -> Reading:
        block = self._terminal.read()
        plausible = self._safety.see(time, block)
        self._down_since = None
        return Reading(self._scaling.lengths(block), self._scaling.pressures(block), plausible)

    def _connect_again(self, time: float) -> None:
        self._terminal.reconnect()
        intact = False
        if self._armed:
            # A terminal that was restarted has forgotten its watchdog.
            intact = self._terminal.watchdog() == self._map.watchdog.word
            if not intact:
                self._terminal.arm_watchdog()
        self._safety.link_made(time, intact=intact)

    def _fail(self, time: float, error: TerminalError) -> None:
        self.failures += 1
        self._safety.link_failed(time, str(error), gone=error.gone)
        if self._down_since is None:
            self._down_since = time
        # At once as long as the connection does not count as lost; then now and again.
        lost = time - self._down_since > self._map.timeouts.link
        self._retry_at = time + (self._map.timeouts.reconnect if lost else 0.0)
