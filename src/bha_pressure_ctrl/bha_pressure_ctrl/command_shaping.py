"""How a new command is brought on: evenly, with a lead for what lags, expecting what will come.

The lengths commanded, and the pressures of the model for them, are averaged over two times in a
row, together `smoothing_time`: a step becomes a ramp with rounded ends, which is over where lags
would still come nearer. What the bellows' memory and the trunk's inertia cost is added. Of that,

- the pressures to apply are those that a lag of first order, that of the valves and hoses as it was
  identified, turns into it; within the range: what that takes away is made up for later;
- the lengths to expect come later by the dead time, and by a lag.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.settings import check_settings, setting
from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics
from bha_pressure_ctrl.bellows_memory import BellowsMemory

Array = NDArray[np.float64]

_FAR = 5e-3  # [m] beyond what is expected; from there on the robot was really elsewhere
_SMOOTHING = (0.75, 0.25)  # shares of the smoothing time, each averaged over after the other
_FAR_TIME = 1.0  # [s] for which it must be there: steps are not foreseen to the millimetre


@dataclass(frozen=True)
class ShapingSettings:
    """How commands are brought on."""

    smoothing_time: float = setting(
        0.48,
        "Time in which the step of a command is brought on [s]",
        low=0.0,
        high=10.0,
    )
    response_lag: float = setting(
        0.08,
        "Lag with which lengths are expected to follow what is asked for [s]",
        low=0.0,
        high=5.0,
    )
    shortfall: float = setting(
        3e-4,
        "Distance by which lengths are to fall short of a new command at first, made up for over "
        "the second after [m]",
        low=0.0,
        high=0.01,
    )

    def __post_init__(self) -> None:
        check_settings(self)


class CommandShaping:
    """Advances the pressures to apply and the lengths to expect.

    Parameters
    ----------
    settings : Times.
    dynamics : What was identified of the robot.
    period : Time between two updates [s].
    lengths : Lengths at the start, where the bellows have rested [m], shape (9,).
    pressures : Pressures of the model for them [Pa], shape (9,).
    """

    def __init__(
        self,
        settings: ShapingSettings,
        dynamics: BellowsDynamics,
        *,
        period: float,
        lengths: Array,
        pressures: Array,
    ) -> None:
        # Lengths and pressures in one array: they go the same way.
        begin = np.concatenate([lengths, pressures])
        self._means = [
            _Mean(begin, max(1, round(share * settings.smoothing_time / period)))
            for share in _SMOOTHING
        ]
        self._inertia = dynamics.inertia / period**2
        self._before = self._long_before = lengths
        self._costs = dynamics.memory
        self._memory = BellowsMemory(lengths, period)
        self._fill_share = _share(dynamics.fill_lag, period)
        self._vent_share = _share(dynamics.vent_lag, period)
        self._valves = pressures
        self._response_share = _share(settings.response_lag + dynamics.response_lag, period)
        self._expected = lengths
        self._waiting = deque([lengths] * round(dynamics.dead_time / period))
        self._far_share = _share(_FAR_TIME, period)
        self._apart = np.zeros(bellows.COUNT)

    def update(
        self, target: Array, measured: Array, low: Array, high: Array
    ) -> tuple[Array, Array]:
        """Advance by one period.

        Parameters
        ----------
        target : Commanded lengths [m] and pressures of the model for them [Pa], shape (18,).
        measured : Measured lengths [m], shape (9,).
        low, high : Range that is left to the pressures to apply [Pa], shape (9,).

        Returns
        -------
        Pressures to apply [Pa] and lengths to expect [m], both of shape (9,).
        """
        for mean in self._means:
            target = mean.update(target)
        lengths, pressures = target[: bellows.COUNT], target[bellows.COUNT :]
        accelerated = lengths - 2.0 * self._before + self._long_before
        self._before, self._long_before = lengths, self._before
        self._apart = self._apart + self._far_share * (measured - self._expected - self._apart)
        far = self._apart - np.minimum(np.maximum(self._apart, -_FAR), _FAR)
        states = self._memory.update(lengths + far)
        wanted = pressures + (self._costs * states).sum(axis=0) + self._inertia @ accelerated
        away = wanted - self._valves
        shares = np.where(away > 0.0, self._fill_share, self._vent_share)
        applied = np.minimum(np.maximum(self._valves + away / shares, low), high)
        self._valves = self._valves + shares * (applied - self._valves)
        self._waiting.append(lengths)
        come = self._waiting.popleft()
        self._expected = self._expected + self._response_share * (come - self._expected)
        return applied, self._expected


class _Mean:
    """The mean of the last values, all of them the first at the start."""

    def __init__(self, start: Array, count: int) -> None:
        self._part = 1.0 / count
        self._value, self._last = start, deque([start * self._part] * count)

    def update(self, value: Array) -> Array:
        part = value * self._part
        self._last.append(part)
        self._value = self._value + (part - self._last.popleft())
        return self._value


def _share(time: float, period: float) -> float:
    """Return how much of the way a lag of first order goes in a period."""
    return -float(np.expm1(-period / time)) if time > 0.0 else 1.0
