"""The robot's time on hardware: the system's time, but never stepping."""

from __future__ import annotations

import time
from collections.abc import Callable


class RobotTime:
    """Begins at the system's time and goes on with the steady clock.

    Trackers stamp with the system's time, so both agree; but a system clock that is set while the
    robot runs must not make timeouts of it.

    Parameters
    ----------
    system, steady : The clocks [ns].
    """

    def __init__(
        self,
        system: Callable[[], int] = time.time_ns,
        steady: Callable[[], int] = time.monotonic_ns,
    ) -> None:
        self._steady = steady
        self._offset = system() - steady()

    def now(self) -> int:
        """Tell the time [ns]."""
        return self._steady() + self._offset


class Ticks:
    """Cycles at whole multiples of a period; what was missed is left out, not made up for.

    Parameters
    ----------
    period : Time between two ticks [ns].
    """

    def __init__(self, period: int) -> None:
        self._period = period
        self._last = 0
        self.missed = 0
        """How many ticks were left out."""

    def wait(self, now: int) -> int:
        """Tell how long it is until the next tick is due [ns]; 0 or less when it is."""
        return self._last + self._period - now if self._last else 0

    def take(self, now: int) -> int:
        """Begin the tick that is due, and tell its time: the newest multiple of the period."""
        tick = now // self._period * self._period
        if self._last:
            self.missed += max(0, (tick - self._last) // self._period - 1)
        self._last = tick
        return tick
