"""How the exchanges of a driver lie in time, seen from the terminal."""

from __future__ import annotations

from collections import deque

import numpy as np


class ExchangeTiming:
    """Counts what comes between a read of the lengths and the write that answers it.

    The robot behind an emulated terminal lives in steps. In a chain without loss each step is read
    once, and its answer is written before the next step, as in the simulator.
    """

    def __init__(self) -> None:
        self.cycles = 0
        """Writes that answered a read."""
        self.stale = 0
        """Reads of a state that had been read before."""
        self.skipped = 0
        """Steps that nobody has read."""
        self.late = 0
        """Writes that came when the robot had gone on since the read."""
        self._steps = 0  # since the last read
        self._read_at: float | None = None
        self._times: deque[float] = deque(maxlen=3000)

    def stepped(self) -> None:
        """Take note of a step of the robot."""
        self._steps += 1

    def read(self, now: float) -> None:
        """Take note of a read of the lengths at `now` [s]."""
        if self._read_at is not None or self.cycles:
            self.stale += self._steps == 0
            self.skipped += max(0, self._steps - 1)
        self._steps, self._read_at = 0, now

    def written(self, now: float) -> None:
        """Take note of a write of set-points at `now` [s]."""
        if self._read_at is None:
            return
        self.cycles += 1
        self.late += self._steps > 0
        self._times.append(now - self._read_at)
        self._read_at = None

    @property
    def median(self) -> float:
        """Median time from a read to its write, of the last minute at 50 Hz [s]; NaN for none."""
        return float(np.median(self._times)) if self._times else float("nan")

    @property
    def longest(self) -> float:
        """Longest such time [s]."""
        return float(np.max(self._times)) if self._times else float("nan")
