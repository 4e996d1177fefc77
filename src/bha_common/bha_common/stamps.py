"""Which stamps of a robot's stream to believe, and when the robot has started anew."""

from __future__ import annotations

import math
from collections.abc import Callable

_RESTART_MESSAGES = 3


class StampError(ValueError):
    """A stamp that cannot be used; the message says why."""


class StreamClock:
    """The robot's time as its own state messages tell it.

    Nodes take the time from the stamps of the lengths and not from a clock of their own, so that
    they compute the same whether the robot runs in real time, faster, or in lockstep. A state that
    is not newer than the last one is refused, and so is one that leaps ahead; but several such
    states that go on from one another are believed. When they are not newer, the robot was started
    anew; when they are, it went on while nobody listened.

    Parameters
    ----------
    on_restart : Called when the robot has started anew, before its time is taken over.
    max_gap : Largest time between two states of one run [s].
    """

    def __init__(
        self, on_restart: Callable[[], None] | None = None, max_gap: float = math.inf
    ) -> None:
        self._on_restart = on_restart
        self._max_gap = max_gap * 1e9
        self._now: int | None = None
        self._doubted: list[int] = []

    @property
    def now(self) -> int | None:
        """Stamp of the newest state [ns]; None before the first."""
        return self._now

    def advance(self, stamp: int) -> None:
        """Take the stamp of a new state.

        Parameters
        ----------
        stamp : Stamp of the message [ns].

        Raises
        ------
        StampError
            When the message must be dropped.
        """
        if stamp <= 0:
            raise StampError("no stamp: the robot's time begins above 0")
        now = self._now
        if now is None or 0 < stamp - now <= self._max_gap:
            self._now = stamp
            self._doubted.clear()
            return
        if self._doubted and not 0 < stamp - self._doubted[-1] <= self._max_gap:
            self._doubted.clear()
        self._doubted.append(stamp)
        if len(self._doubted) < _RESTART_MESSAGES:
            raise StampError(
                f"stamp {stamp * 1e-9:.3f} s is not newer than the last one, {now * 1e-9:.3f} s"
                if stamp <= now
                else f"stamp {stamp * 1e-9:.3f} s leaps ahead of the last one, {now * 1e-9:.3f} s"
            )
        self._doubted.clear()
        if stamp <= now and self._on_restart is not None:
            self._on_restart()
        self._now = stamp


def check_command_stamp(stamp: int, now: int | None, max_age: float) -> None:
    """Refuse a command that no one can have meant for now.

    Parameters
    ----------
    stamp : Stamp of the command [ns]; 0 is no stamp.
    now : Robot time [ns]; None when it is not known yet.
    max_age : Largest age, and largest distance into the future [s].

    Raises
    ------
    StampError
        When there is no stamp, or it is too far from the robot's time.
    """
    if stamp == 0:
        raise StampError("no stamp: set header.stamp to that of the lengths you answer")
    if now is None:
        raise StampError("the robot's time is not known yet: no state has arrived")
    age = (now - stamp) * 1e-9
    if abs(age) > max_age:
        raise StampError(f"stamp is {age:.3f} s old; at most {max_age:.3f} s is taken")
