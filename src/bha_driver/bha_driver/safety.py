"""What may be written to the terminal, whatever the controller wants: one state machine.

It knows neither sockets nor clocks: what it decides follows from the times and values that it is
told. Pressures rise only while the driver is active, no fault is latched and valid commands come.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.command_gate import CommandGate, SafetySettings
from bha_driver.plausibility import Plausibility
from bha_driver.scaling import Scaling
from bha_driver.terminal_map import TerminalMap

Array = NDArray[np.float64]
Words = NDArray[np.int64]

EMERGENCY_STOP = "emergency stop"
LINK_LOST = "connection lost"
RESTARTED = "terminal restarted"
OVERSLEPT = "writes overdue"

_SHUTDOWN_TIME = 1.0  # [s] from full pressure to none when the driver ends


@dataclass(frozen=True)
class Fault:
    """Why the driver is in its safe state: latched until an explicit reset.

    Attributes
    ----------
    which : The kind, such as ``connection lost``.
    why : What was seen.
    time : When [s].
    """

    which: str
    why: str
    time: float

    def __str__(self) -> str:
        return f"{self.which}: {self.why}" if self.why else self.which


class Safety:
    """Decides at every cycle which set-points are written, or that none are.

    Parameters
    ----------
    terminal : The terminal's map with its limits.
    settings : Watchdog and safe state, as the simulator has them.
    period : Time between two cycles [s]; a pressure never changes by more than one period's worth
        from one write to the next, however late it is.
    """

    INACTIVE = "inactive"

    def __init__(self, terminal: TerminalMap, settings: SafetySettings, period: float) -> None:
        self._map, self._settings, self._period = terminal, settings, period
        self._gate = CommandGate(settings)
        self._scaling = Scaling(terminal)
        self._plausibility = Plausibility(terminal.limits)
        self._faults: list[Fault] = []
        self._active = False
        self._linked = False
        self._bad_range = ""
        self._link_trouble = "never connected"
        self._read_at = -np.inf  # time of the last good read
        self._written_at = -np.inf  # time of the last confirmed write
        self._last: float | None = None  # time of the last decision
        self._applied = np.zeros(bellows.COUNT)
        self._pressing = False
        self._venting_done = (
            False  # whether the set-points decided on last are those of no pressure
        )

    @property
    def faults(self) -> tuple[Fault, ...]:
        """What is latched, oldest first."""
        return tuple(self._faults)

    @property
    def stopped(self) -> bool:
        """Whether something is latched."""
        return bool(self._faults)

    @property
    def active(self) -> bool:
        """Whether the driver may press."""
        return self._active

    @property
    def pressing(self) -> bool:
        """Whether the terminal may hold pressures, as far as is known."""
        return self._pressing

    @property
    def state(self) -> str:
        """INACTIVE, or what `CommandGate.state` tells: running, silent, stopped."""
        return self._gate.state if self._active else self.INACTIVE

    @property
    def applied(self) -> Array:
        """Pressures that the terminal was told last [Pa], shape (9,)."""
        return self._applied.copy()

    # --- what is wanted --------------------------------------------------------------------

    def activate(self, time: float) -> str:
        """Allow pressing from `time` [s] on; the reason when that cannot be, else empty."""
        if self._faults:
            return f"reset first: {self._faults[0]}"
        if not self._linked:
            return f"not connected: {self._link_trouble}"
        if self._bad_range:
            return self._bad_range
        if not self._active:
            self._gate.drop(time)
            self._active, self._last = True, None
            self._read_at = self._written_at = time
        return ""

    def deactivate(self, time: float) -> None:
        """Vent, and drive nothing after that."""
        self._active = False
        self._gate.drop(time)

    def offer(self, time: float, pressures: Array) -> None:
        """Take a valid command of `time` [s]: pressures [Pa], shape (9,)."""
        if self._active and self._linked:
            self._gate.offer(time, pressures)

    def stop(self, time: float) -> None:
        """Latch the emergency stop."""
        self._latch(EMERGENCY_STOP, "", time)

    def reset(self, time: float) -> str:
        """End what is latched; the reason when its cause is still there, else empty.

        Only a command newer than `time` [s] counts after that.
        """
        if self._active and not self._linked:
            return f"not connected: {self._link_trouble}"
        if self._active and self._bad_range:
            return self._bad_range
        self._faults.clear()
        self._plausibility.forget()
        self._gate.reset_stop(time)
        return ""

    # --- what is seen ----------------------------------------------------------------------

    def link_made(self, time: float, *, intact: bool) -> None:
        """Take note of a new connection.

        Parameters
        ----------
        time : Now [s].
        intact : Whether the terminal is known to have kept what was written to it: it has neither
            been restarted nor vented since.
        """
        if not intact:
            if self._pressing:
                self._latch(RESTARTED, "what it held is gone, or not known", time)
            self._begin_at_nothing()
        self._linked = True

    def link_failed(self, time: float, why: str = "", *, gone: bool = False) -> None:
        """Take note of an exchange that failed, or of a connection that cannot be made.

        Parameters
        ----------
        time : Now [s].
        why : What happened; empty when nothing new did.
        gone : Whether the terminal itself has ended the connection, or is not there: that counts
            at once. An answer may be late a few times.
        """
        self._linked, self._link_trouble = False, why or self._link_trouble
        if self._active or self._pressing:
            silence = time - min(self._read_at, self._written_at)
            # Half a cycle of slack: times of cycles are not exact.
            if gone or silence > self._map.timeouts.link - 0.5 * self._period:
                self._latch(LINK_LOST, self._link_trouble, time)

    def see(self, time: float, block: Words) -> bool:
        """Judge what was read at `time` [s]; whether the lengths can be believed."""
        self._read_at = time
        which, why = self._plausibility.judge(
            time, self._scaling.raw_lengths(block), self._scaling.lengths(block), self._applied
        )
        self._bad_range = self._plausibility.out_of_range(self._scaling.lengths(block))
        if which and (self._active or self._pressing):
            self._latch(which, why, time)
        return not which

    def confirmed(self, time: float) -> None:
        """Take note that the last set-points were written at `time` [s]."""
        self._written_at = time
        self._pressing = not self._venting_done

    # --- what is written -------------------------------------------------------------------

    def set_points(self, time: float, *, ending: bool = False) -> Words | None:
        """Decide what to write now.

        Parameters
        ----------
        time : Now [s].
        ending : Vent within a second, since the driver ends.

        Returns
        -------
        Raw set-points, shape (9,), as one block; None when nothing is to be written.
        """
        if not self._linked:
            return None
        elapsed = 0.0 if self._last is None else min(max(time - self._last, 0.0), self._period)
        self._last = time
        if not self._active and not self._pressing:
            return None
        # A write that arrives when the terminal has vented by itself would press again.
        limit = self._map.watchdog.time - self._map.timeouts.request
        if self._pressing and time - self._written_at > limit:
            self._latch(OVERSLEPT, f"none for {time - self._written_at:.2f} s", time)
            self._begin_at_nothing()
        target = self._target(time, elapsed, ending)
        step = self._map.limits.pressure_rate * elapsed
        self._applied = np.clip(target, self._applied - step, self._applied + step)
        self._gate.applied(self._applied)
        block = self._scaling.set_points(self._applied)
        self._venting_done = np.array_equal(block, self._scaling.vented)
        # What is not confirmed may have been taken all the same.
        self._pressing = self._pressing or not self._venting_done
        return block

    def _target(self, time: float, elapsed: float, ending: bool) -> Array:
        if self._active and not ending:
            wanted = self._gate.pressures(time, elapsed)
            return np.minimum(wanted, self._map.limits.pressure)
        rate = self._settings.vent_rate
        if ending:
            rate = max(rate, self._map.limits.pressure / _SHUTDOWN_TIME)
        return np.maximum(self._applied - rate * elapsed, 0.0)

    def _begin_at_nothing(self) -> None:
        """Go on from no pressure: the terminal has vented, or nobody knows what it holds."""
        self._applied = np.zeros(bellows.COUNT)
        self._gate.applied(self._applied)

    def _latch(self, which: str, why: str, time: float) -> None:
        self._gate.stop()
        if all(fault.which != which for fault in self._faults):
            self._faults.append(Fault(which, why, time))
