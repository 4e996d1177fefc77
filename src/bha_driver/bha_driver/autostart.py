"""Brings the driver by itself to the state that is wanted, until that has worked once."""

from __future__ import annotations

CHOICES = ("none", "configure", "activate")

_STATES = ("unconfigured", "inactive", "active")
_AGAIN = 1.0  # [s] between two tries


class Autostart:
    """Tells which transition to try next; what a person undoes later stays undone.

    Parameters
    ----------
    wanted : One of `CHOICES`.
    """

    def __init__(self, wanted: str) -> None:
        self._goal = CHOICES.index(wanted)
        self._done = False
        self._tried, self._due = "", 0.0

    def next_step(self, state: str, now: float) -> str:
        """Name the transition to try now, ``configure`` or ``activate``; empty for none.

        Parameters
        ----------
        state : Name of the present state of the life cycle.
        now : Steady time [s].
        """
        if self._done or state not in _STATES:
            return ""
        if _STATES.index(state) >= self._goal:
            self._done = True
            return ""
        if state == self._tried and now < self._due:
            return ""
        self._tried, self._due = state, now + _AGAIN
        return CHOICES[_STATES.index(state) + 1]
