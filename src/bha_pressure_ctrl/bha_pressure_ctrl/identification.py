"""Collects settled samples (lengths and the pressures that hold them) from a running robot."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from bha_common import bellows
from bha_common.settings import check_settings, setting
from bha_pressure_ctrl.bellows_memory import STATES, BellowsMemory
from bha_pressure_ctrl.pressure_steps import PressureSteps

Array = NDArray[np.float64]

_NOISE_TIME = 0.3  # [s] over which readings are averaged before they are taken as remembered


@dataclass(frozen=True)
class IdentificationSettings:
    """How the samples for the equilibrium model are taken."""

    samples: int = setting(60, "Settled postures to collect", low=20, high=10_000)
    pressure_rate: float = setting(
        6e4, "Fastest change of a pressure on the way to the next posture [Pa/s]", low=1e3
    )
    rest_speed: float = setting(
        4e-4, "Speed of the lengths below which they count as at rest [m/s]", low=1e-5
    )
    rest_window: float = setting(
        1.0, "Time over which lengths are averaged to find their speed [s]", low=0.1
    )
    max_settling: float = setting(
        15.0, "Time after which a posture is taken as settled in any case [s]", low=1.0
    )
    steps: int = setting(
        4, "Steps of all pressures at the end, from which the lags are read", low=0, high=100
    )

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, eq=False)
class Records:
    """What identification saw while pressures stood still, a row for every `rest_window`.

    Attributes
    ----------
    lengths : Mean lengths [m], shape (n, 9).
    pressures : Applied [Pa], shape (n, 9).
    states : Mean states of the bellows' memory [m], shape (n, STATES, 9).
    times : When the row ended [s], shape (n,).
    settled : Whether the posture had settled, shape (n,).
    """

    lengths: Array
    pressures: Array
    states: Array
    times: Array
    settled: NDArray[np.bool_]


class Identification:
    """Asks for pressures, is told lengths, until there are enough settled samples.

    The postures are a scrambled Sobol sequence over the box of pressures, so that few of them
    cover it evenly. A few steps of all pressures follow, which show how the lengths lag.

    Parameters
    ----------
    settings : How samples are taken.
    samples : Number of postures; None takes that of the settings.
    max_pressure : Upper end of the box [Pa].
    start : Pressures that are applied now [Pa], shape (9,).
    period : Time between two updates [s].
    seed : Seed of the sequence of postures.

    Raises
    ------
    ValueError
        When there is no posture to collect.
    """

    def __init__(
        self,
        settings: IdentificationSettings,
        *,
        max_pressure: float,
        start: Array,
        period: float,
        seed: int,
        samples: int | None = None,
    ) -> None:
        self._settings = settings
        self._period = period
        self.requested = settings.samples if samples is None else samples
        if self.requested < 1:
            raise ValueError(f"samples must be at least 1, got {self.requested}")
        sequence = qmc.Sobol(bellows.COUNT, scramble=True, seed=seed)
        exponent = max(1, int(np.ceil(np.log2(self.requested))))
        self._targets = max_pressure * sequence.random_base2(exponent)[: self.requested]
        self._output = np.array(start, dtype=np.float64)
        half = max(1, round(settings.rest_window / period))
        self._half = half
        self._window: deque[Array] = deque(maxlen=2 * half)
        self._states: deque[Array] = deque(maxlen=half)
        self._settled_for = 0
        self.elapsed = 0.0
        self.collected = 0
        self._motion: list[tuple[Array, Array, Array]] = []
        self._rows: list[tuple[Array, Array, Array, float, bool]] = []
        self._smoothed: Array | None = None
        self._smoothing = -float(np.expm1(-period / _NOISE_TIME))
        self._memory: BellowsMemory | None = None
        self._max_pressure = max_pressure
        self._steps: PressureSteps | None = None

    @property
    def done(self) -> bool:
        """Whether all postures are collected and the steps are over."""
        if self.collected < self.requested:
            return False
        return self._settings.steps == 0 or (self._steps is not None and self._steps.done)

    def samples(self) -> tuple[Array, Array]:
        """Lengths [m] and pressures [Pa] of the settled postures so far, both of shape (n, 9)."""
        records = self.records()
        return records.lengths[records.settled], records.pressures[records.settled]

    def records(self) -> Records:
        """All that was seen so far while pressures stood still."""
        lengths, pressures, states, times, settled = (
            zip(*self._rows, strict=True) if self._rows else [()] * 5
        )
        return Records(
            np.array(lengths).reshape(-1, bellows.COUNT),
            np.array(pressures).reshape(-1, bellows.COUNT),
            np.array(states).reshape(-1, STATES, bellows.COUNT),
            np.array(times, dtype=np.float64),
            np.array(settled, dtype=np.bool_),
        )

    def motion(self) -> tuple[Array, Array, Array]:
        """Every period on the way to all postures, for n of them.

        Returns
        -------
        Lengths [m], shape (n, 9), pressures told in answer [Pa], (n, 9), and states of the bellows'
        memory [m], (n, STATES, 9).
        """
        lengths, pressures, states = (np.array(each) for each in zip(*self._motion, strict=True))
        return lengths, pressures, states

    @property
    def steps(self) -> PressureSteps | None:
        """The steps at the end; None before they begin."""
        return self._steps

    def update(self, lengths: Array) -> Array:
        """Take the lengths of one control period and tell the pressures for the next.

        Parameters
        ----------
        lengths : Measured lengths [m], shape (9,).

        Returns
        -------
        Pressures to apply [Pa], shape (9,).
        """
        self.elapsed += self._period
        if self.collected == self.requested:
            return self._step(lengths)
        states = self._remember(lengths)
        target = self._targets[self.collected]
        step = self._settings.pressure_rate * self._period
        self._output = self._output + np.clip(target - self._output, -step, step)
        self._motion.append((lengths, self._output, states))
        if not np.array_equal(self._output, target):
            self._wait_anew()
            return self._output
        self._window.append(lengths)
        self._states.append(states)
        self._settled_for += 1
        if self._at_rest():
            self._note(target, settled=True)
            self.collected += 1
            self._wait_anew()
        elif self._settled_for % self._half == 0 and self._settled_for > self._half:
            self._note(target, settled=False)
        return self._output

    def _remember(self, lengths: Array) -> Array:
        if self._smoothed is None or self._memory is None:
            self._smoothed, self._memory = lengths, BellowsMemory(lengths, self._period)
        self._smoothed = self._smoothed + self._smoothing * (lengths - self._smoothed)
        return self._memory.update(self._smoothed)

    def _wait_anew(self) -> None:
        self._window.clear()
        self._states.clear()
        self._settled_for = 0

    def _note(self, pressures: Array, settled: bool) -> None:
        lengths = np.mean(list(self._window)[-self._half :], axis=0)
        states = np.mean(self._states, axis=0)
        self._rows.append((lengths, pressures, states, self.elapsed, settled))

    def _at_rest(self) -> bool:
        if len(self._window) != self._window.maxlen:
            return False
        if self._settled_for * self._period >= self._settings.max_settling:
            return True
        window = np.array(self._window)
        moved = np.abs(window[self._half :].mean(axis=0) - window[: self._half].mean(axis=0)).max()
        return bool(moved < self._settings.rest_speed * self._settings.rest_window)

    def _step(self, lengths: Array) -> Array:
        if self._steps is None:
            self._steps = PressureSteps(
                self._settings.steps,
                max_pressure=self._max_pressure,
                start=self._output,
                rate=self._settings.pressure_rate,
                period=self._period,
            )
        if not self._steps.done:
            self._output = self._steps.update(lengths)
        return self._output
