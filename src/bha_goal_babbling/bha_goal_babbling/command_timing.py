"""When the learner commands: once a command period, as soon as the tip of that period is there."""

from __future__ import annotations

TIP_LOST = 1_000_000_000
"""Age at which a tip says nothing of a command period any more, and none is waited for [ns]."""


class CommandTiming:
    """Tells when a command is to be given.

    Parameters
    ----------
    period : float
        Robot time from one command to the next [s].
    tip_timeout : float
        Robot time for which a command waits for the tip of its period [s].
    """

    def __init__(self, period: float, tip_timeout: float) -> None:
        self._period = round(period * 1e9)
        self._patience = round(tip_timeout * 1e9)
        self._due: int | None = None

    def advance(self, before: int | None, now: int) -> None:
        """Take the stamps of the robot's last state and of its new one [ns].

        A command is due at each multiple of the period, or when one was passed: stamps may lie
        anywhere.
        """
        passed = before is not None and now // self._period > before // self._period
        if passed or now % self._period == 0:
            self._due = now

    def take(self, now: int, tip: int | None) -> int | None:
        """Return the stamp [ns] of the command that is to be given now, and return it once.

        Parameters
        ----------
        now : int
            The robot's time [ns].
        tip : int or None
            Stamp of the newest tip [ns]; None when none was seen.
        """
        due = self._due
        if due is None:
            return None
        comes = tip is not None and due - tip <= TIP_LOST
        if comes and tip is not None and tip < due and now - due < self._patience:
            return None
        self._due = None
        return due

    def forget(self) -> None:
        """Give no command until the next one is due."""
        self._due = None
