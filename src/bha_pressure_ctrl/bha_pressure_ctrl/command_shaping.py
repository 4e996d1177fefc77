"""How a new command is brought on: smoothly, with a lead for what lags, expecting what will come.

A step of a command becomes two things, both reached through two lags of first order in a row
(`smoothing_time` each), so that the trunk is not set swinging:

- pressures, from those of the model for the last command to those for the new one, with a lead that
  makes up for the lag of valves and hoses, and a surplus that fades for the creep of the bellows:

      applied = p + valve_lag dp/dt + creep_share (p - c),      dc/dt = (p - c) / creep_time

- the lengths to expect of them: delayed by the dead time, and by one more lag, that of the trunk.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common.settings import check_settings, setting

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ShapingSettings:
    """How commands are brought on; what a lab sees in the lengths after a step of the pressures."""

    smoothing_time: float = setting(
        0.15, "Time constant of each of the two lags of a command [s]", low=0.0, high=10.0
    )
    valve_lag: float = setting(
        0.3, "Lag of valves and hoses that is made up for [s]", low=0.0, high=2.0
    )
    creep_share: float = setting(
        0.2,
        "Share of a change of pressure that is added until the bellows have crept",
        high=1.0,
        low=0.0,
    )
    creep_time: float = setting(3.0, "Time in which they creep [s]", low=0.1, high=100.0)
    dead_time: float = setting(
        0.06, "Time until the lengths begin to follow [s]", low=0.0, high=1.0
    )
    response_lag: float = setting(
        0.13, "Lag of the lengths behind the pressures [s]", low=0.0, high=5.0
    )

    def __post_init__(self) -> None:
        check_settings(self)


class _Lag:
    """A lag of first order, exact for an input that holds for a period."""

    def __init__(self, time: float, period: float, start: Array) -> None:
        self._share = -float(np.expm1(-period / time)) if time > 0.0 else 1.0
        self.value = start

    def update(self, target: Array) -> Array:
        self.value = self.value + self._share * (target - self.value)
        return self.value


class CommandShaping:
    """Advances the pressures to apply and the lengths to expect.

    Parameters
    ----------
    settings : Lags and leads.
    period : Time between two updates [s].
    lengths : Lengths at the start [m], shape (9,).
    pressures : Pressures of the model for them [Pa], shape (9,).
    """

    def __init__(
        self, settings: ShapingSettings, *, period: float, lengths: Array, pressures: Array
    ) -> None:
        times = (settings.smoothing_time, settings.smoothing_time)
        self._pressures = [_Lag(time, period, pressures) for time in times]
        self._lengths = [_Lag(time, period, lengths) for time in (*times, settings.response_lag)]
        self._crept = _Lag(settings.creep_time, period, pressures)
        self._waiting = deque([lengths] * round(settings.dead_time / period))
        self._lead = settings.valve_lag / period
        self._creep_share = settings.creep_share

    def update(self, lengths: Array, pressures: Array) -> tuple[Array, Array]:
        """Advance by one period.

        Parameters
        ----------
        lengths : Commanded lengths [m], shape (9,).
        pressures : Pressures of the model for them [Pa], shape (9,).

        Returns
        -------
        Pressures to apply [Pa] and lengths to expect [m], both of shape (9,).
        """
        before = self._pressures[1].value
        now = self._pressures[1].update(self._pressures[0].update(pressures))
        surplus = self._creep_share * (now - self._crept.update(now))
        self._waiting.append(self._lengths[1].update(self._lengths[0].update(lengths)))
        expected = self._lengths[2].update(self._waiting.popleft())
        return now + self._lead * (now - before) + surplus, expected
