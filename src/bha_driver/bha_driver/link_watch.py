"""Whether the terminal is there: since when it is silent, and what its watchdog has done by now."""

from __future__ import annotations

import numpy as np

from bha_driver.terminal_map import TerminalMap


class LinkWatch:
    """Keeps the times of the last good exchanges.

    Parameters
    ----------
    terminal : The terminal's map with its timeouts and its watchdog.
    period : Time between two cycles [s].
    """

    def __init__(self, terminal: TerminalMap, period: float) -> None:
        self._link_time = terminal.timeouts.link
        # A write that arrives when the terminal has vented by itself would press again.
        self._write_limit = terminal.watchdog.time - terminal.timeouts.request
        self._period = period
        self.linked = False
        """Whether there is a connection, as far as is known."""
        self.trouble = "never connected"
        """What happened last to the connection, for people."""
        self._read_at = -np.inf
        self._written_at = -np.inf

    def begin(self, time: float) -> None:
        """Count silence from `time` [s] on."""
        self._read_at = self._written_at = time

    def failed(self, why: str) -> None:
        """Take note that there is no connection any more; `why` may be empty: as before."""
        self.linked, self.trouble = False, why or self.trouble

    def read(self, time: float) -> None:
        """Take note of a good read at `time` [s]."""
        self._read_at = time

    def written(self, time: float) -> None:
        """Take note of set-points that were decided on at `time` [s] and confirmed."""
        self._written_at = time

    def lost(self, time: float) -> bool:
        """Whether reads or writes have failed for so long that the connection counts as lost.

        Reads alone are not enough: a terminal that refuses every write holds the old pressures.
        """
        silence = time - min(self._read_at, self._written_at)
        # Half a cycle of slack: times of cycles are not exact.
        return silence > self._link_time - 0.5 * self._period

    def overdue(self, time: float) -> float:
        """Tell for how long nothing was written, if the terminal may have vented since; else 0."""
        silence = time - self._written_at
        return silence if silence > self._write_limit else 0.0
