"""What may be written to the terminal, whatever the controller wants: one state machine.

It knows neither sockets nor clocks: what it decides follows from the times and values that it is
told. Pressures rise only while the driver is active, no fault is latched and valid commands come.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.command_gate import CommandGate, SafetySettings
from bha_driver.latched_faults import (
    EMERGENCY_STOP,
    LINK_LOST,
    OVERSLEPT,
    RESTARTED,
    Fault,
    LatchedFaults,
)
from bha_driver.link_watch import LinkWatch
from bha_driver.plausibility import Plausibility
from bha_driver.scaling import Scaling
from bha_driver.set_points import SetPoints
from bha_driver.terminal_map import TerminalMap

Array = NDArray[np.float64]
Words = NDArray[np.int64]

_SHUTDOWN_TIME = 1.0  # [s] from full pressure to none when the driver ends


class Safety:
    """Decides at every cycle which set-points are written, or that none are.

    Parameters
    ----------
    terminal : The terminal's map with its limits.
    settings : Watchdog and safe state, as the simulator has them.
    period : Time between two cycles [s].
    """

    INACTIVE = "inactive"

    def __init__(self, terminal: TerminalMap, settings: SafetySettings, period: float) -> None:
        self.period = period
        """Time between two cycles [s]."""
        self._limits, self._settings = terminal.limits, settings
        self._gate = CommandGate(settings)
        self._scaling = Scaling(terminal)
        self._plausibility = Plausibility(terminal.limits)
        self._link = LinkWatch(terminal, period)
        self._set_points = SetPoints(terminal, period)
        self._faults = LatchedFaults()
        self._active = False
        self._doubt = ""  # why the newest lengths cannot be believed

    @property
    def faults(self) -> tuple[Fault, ...]:
        """What is latched, oldest first."""
        return self._faults.all

    @property
    def stopped(self) -> bool:
        """Whether something is latched."""
        return bool(self._faults)

    @property
    def link_lost(self) -> bool:
        """Whether it is latched that the connection is lost."""
        return any(fault.which == LINK_LOST for fault in self.faults)

    @property
    def pressing(self) -> bool:
        """Whether the terminal may hold pressures, as far as is known."""
        return self._set_points.pressing

    @property
    def state(self) -> str:
        """INACTIVE, or what `CommandGate.state` tells: running, silent, stopped."""
        return self._gate.state if self._active else self.INACTIVE

    @property
    def applied(self) -> Array:
        """Pressures that the terminal was told last [Pa], shape (9,)."""
        return self._set_points.applied

    @property
    def trouble(self) -> str:
        """Why this terminal must not be driven as it is now; empty when it may."""
        return self._doubt if self._link.linked else f"not connected: {self._link.trouble}"

    # --- what is wanted --------------------------------------------------------------------

    def refusal(self) -> str:
        """Tell why the driver cannot be activated now; empty when it can."""
        return f"reset first: {self.faults[0]}" if self._faults else self.trouble

    def not_ours(self, held: Words) -> str:
        """Tell that a terminal which holds these set-points is pressed by someone else, else empty.

        Parameters
        ----------
        held : Raw set-points that were read back, shape (9,).
        """
        pressures = self._scaling.commanded(held)
        pressed = pressures >= self._scaling.count_worth
        if not pressed.any() or np.array_equal(held, self._scaling.set_points(self.applied)):
            return ""
        highest = int(np.argmax(pressures))
        return (
            f"the terminal holds {pressures[highest]:.0f} Pa at {bellows.NAMES[highest]}, which "
            "this driver has not written: end the other driver that does, or vent by hand"
        )

    def activate(self, time: float) -> str:
        """Allow pressing from `time` [s] on; the reason when that cannot be, else empty."""
        if reason := self.refusal():
            return reason
        if not self._active:
            self._gate.drop(time)
            self._active = True
            # While it vents still, how long ago the last write was tells what the terminal holds.
            if not self.pressing:
                self._set_points.begin()
                self._link.begin(time)
        return ""

    def deactivate(self, time: float) -> None:
        """Vent, and drive nothing after that."""
        self._active = False
        self._gate.drop(time)

    def offer(self, time: float, pressures: Array) -> None:
        """Take a command of `time` [s]: pressures [Pa], shape (9,); none that is not finite."""
        if self._active and self._link.linked and np.isfinite(pressures).all():
            self._gate.offer(time, pressures)

    def stop(self, time: float) -> None:
        """Latch the emergency stop."""
        self._latch(EMERGENCY_STOP, "", time)

    def reset(self, time: float) -> str:
        """End what is latched; the reason when its cause is still there, else empty.

        Only a command newer than `time` [s] counts after that.
        """
        if self._active and self.trouble:
            return self.trouble
        self._faults.clear()
        self._gate.reset_stop(time)
        return ""

    # --- what is seen ----------------------------------------------------------------------

    def begin(self, time: float) -> None:
        """Take `time` [s] for now, and forget readings: the clock may have been set back."""
        self._plausibility.forget()
        self._link.begin(time)

    def link_made(self, time: float, *, intact: bool) -> None:
        """Take note of a new connection.

        Parameters
        ----------
        time : Now [s].
        intact : Whether the terminal is known to have kept what was written to it: it has neither
            been restarted nor vented since.
        """
        if not intact:
            if self.pressing:
                self._latch(RESTARTED, "what it held is gone, or not known", time)
            self.vent_at_once()
        self._link.linked = True

    def link_failed(self, time: float, why: str = "", *, gone: bool = False) -> None:
        """Take note of an exchange that failed, or of a connection that cannot be made.

        Parameters
        ----------
        time : Now [s].
        why : What happened; empty when nothing new did.
        gone : Whether the terminal itself has ended the connection, or is not there: that counts
            at once. An answer may be late a few times.
        """
        self._link.failed(why)
        if (self._active or self.pressing) and (gone or self._link.lost(time)):
            self._latch(LINK_LOST, self._link.trouble, time)

    def see(self, time: float, block: Words) -> bool:
        """Judge what was read at `time` [s]; whether the lengths can be believed."""
        self._link.read(time)
        raw, lengths = self._scaling.raw_lengths(block), self._scaling.lengths(block)
        which, self._doubt = self._plausibility.judge(time, raw, lengths, self.applied)
        if which and (self._active or self.pressing):
            self._latch(which, self._doubt, time)
        return not which

    def confirmed(self, time: float) -> None:
        """Take note that the set-points decided on at `time` [s] were written."""
        self._link.written(time)
        self._set_points.confirmed()

    # --- what is written -------------------------------------------------------------------

    def vent_at_once(self) -> None:
        """Go on from no pressure, whatever `limits.pressure_rate` says."""
        self._set_points.begin_at_nothing()
        self._gate.applied(self.applied)

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
        if not self._link.linked:
            return None
        elapsed = self._set_points.elapsed(time)
        if not self._active and not self.pressing:
            return None
        overdue = self._link.overdue(time)
        if self.pressing and overdue:
            self._latch(OVERSLEPT, f"none for {overdue:.2f} s", time)
            self.vent_at_once()
        block = self._set_points.move(self._wanted(time, elapsed, ending), elapsed)
        self._gate.applied(self.applied)
        return block

    def _wanted(self, time: float, elapsed: float, ending: bool) -> Array:
        if self._active and not ending:
            return self._gate.pressures(time, elapsed)
        rate = self._settings.vent_rate
        if ending:
            rate = max(rate, self._limits.pressure / _SHUTDOWN_TIME)
        return np.maximum(self.applied - rate * elapsed, 0.0)

    def _latch(self, which: str, why: str, time: float) -> None:
        self._gate.stop()
        self._faults.latch(which, why, time)
