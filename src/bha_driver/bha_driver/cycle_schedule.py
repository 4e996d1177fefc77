"""When a cycle reads, and when it writes: at the answer, or halfway to the next cycle."""

from __future__ import annotations

from bha_driver.robot_time import Ticks


class CycleSchedule:
    """One read and one write a period; all times are those of the robot [ns].

    Parameters
    ----------
    period : Time between two cycles.
    """

    def __init__(self, period: int) -> None:
        self._ticks = Ticks(period)
        self._answer_time = period // 2
        self._write_at: int | None = None

    @property
    def missed(self) -> int:
        """How many cycles were left out."""
        return self._ticks.missed

    def read_due(self, now: int) -> bool:
        """Whether the next cycle begins."""
        return self._ticks.wait(now) <= 0

    def begin(self, now: int) -> int:
        """Begin the cycle that is due, and tell its time; its write is owed from now on."""
        tick = self._ticks.take(now)
        self._write_at = tick + self._answer_time
        return tick

    @property
    def write_owed(self) -> bool:
        """Whether this cycle has not written yet."""
        return self._write_at is not None

    def write_due(self, now: int) -> bool:
        """Whether no answer is waited for any more."""
        return self._write_at is not None and now >= self._write_at

    def written(self) -> None:
        """Take note that this cycle has written, or that it will not."""
        self._write_at = None

    def wait(self, now: int) -> int:
        """Tell how long there is nothing to do [ns]."""
        wait = self._ticks.wait(now)
        if self._write_at is not None:
            wait = min(wait, self._write_at - now)
        return max(wait, 0)
