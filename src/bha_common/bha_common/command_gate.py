"""What a robot lets through of the pressures it is told: watchdog, emergency stop, safe state.

The simulator and the driver use the same gate, so that a robot behaves alike in both.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.settings import check_settings, setting

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SafetySettings:
    """When a robot goes to its safe state, and what that is."""

    command_timeout: float = setting(
        1.0, "Robot time without a valid command after which the safe state begins [s]", low=0.02
    )
    safe_state: str = setting(
        "vent", "What the safe state does with the pressures", choices=("vent", "hold")
    )
    vent_rate: float = setting(
        4e4, "Fastest fall of a pressure while venting to the safe state [Pa/s]", low=1.0
    )
    max_pressure: float = setting(
        bellows.MAX_PRESSURE, "Highest pressure that is let through [Pa]", low=0.0, high=2e5
    )

    def __post_init__(self) -> None:
        check_settings(self)


class CommandGate:
    """Passes valid commands on, and knows what to do when there are none.

    The emergency stop is latched: it ends by `reset_stop` only, and after that the robot stays in
    the safe state until a command arrives that is newer than the reset.

    Parameters
    ----------
    settings : Timeouts and rates.
    """

    RUNNING, SILENT, STOPPED = "running", "silent", "stopped"

    def __init__(self, settings: SafetySettings) -> None:
        self._settings = settings
        self._output = np.zeros(bellows.COUNT)
        self._command: Array | None = None
        self._last = -np.inf
        self._not_before = -np.inf
        self._stopped = False

    @property
    def stopped(self) -> bool:
        """Whether the emergency stop is active."""
        return self._stopped

    @property
    def state(self) -> str:
        """One of RUNNING, SILENT (no valid command in time) and STOPPED."""
        if self._stopped:
            return self.STOPPED
        return self.SILENT if self._command is None else self.RUNNING

    def offer(self, time: float, pressures: Array) -> None:
        """Take a valid command; values out of range are clipped.

        Parameters
        ----------
        time : Robot time of the command [s].
        pressures : Gauge pressures [Pa], shape (9,), finite.
        """
        if self._stopped or time <= self._not_before:
            return
        self._command = np.clip(pressures, 0.0, self._settings.max_pressure)
        self._last = time

    def stop(self) -> None:
        """Latch the emergency stop and forget the command in force."""
        self._stopped = True
        self._command = None

    def drop(self, time: float) -> None:
        """Forget the command in force; only one newer than `time` [s] counts from now on."""
        self._command = None
        self._not_before = time

    def begin_anew(self, time: float) -> None:
        """Take the robot for a fresh one, vented; only a command newer than `time` [s] counts."""
        self.drop(time)
        self._output = np.zeros(bellows.COUNT)

    def reset_stop(self, time: float) -> None:
        """End the emergency stop at robot time `time` [s]; the old command does not come back."""
        self._stopped = False
        self.drop(time)

    def applied(self, pressures: Array) -> None:
        """Take note of what was really applied, where that is not what `pressures` told.

        A driver that limits the rate of pressures applies less than it is told to. The way to the
        safe state begins at what is applied.

        Parameters
        ----------
        pressures : Applied pressures [Pa], shape (9,).
        """
        self._output = pressures

    def pressures(self, time: float, period: float) -> Array:
        """Tell what to apply for the next control period.

        Parameters
        ----------
        time : Robot time now [s].
        period : Control period [s].

        Returns
        -------
        Pressures [Pa], shape (9,).
        """
        # Half a period of slack: stamps are whole nanoseconds, timeouts are not.
        if time - self._last > self._settings.command_timeout + 0.5 * period:
            self._command = None
        if self._command is not None:
            self._output = self._command
        elif self._settings.safe_state == "vent":
            self._output = np.maximum(self._output - self._settings.vent_rate * period, 0.0)
        return self._output
