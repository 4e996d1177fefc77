"""Collects settled samples (lengths and the pressures that hold them) from a running robot."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from bha_common import bellows
from bha_common.settings import check_settings, setting

Array = NDArray[np.float64]


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

    def __post_init__(self) -> None:
        check_settings(self)


class Identification:
    """Asks for pressures, is told lengths, until there are enough settled samples.

    The postures are a scrambled Sobol sequence over the box of pressures, so that few of them
    cover it evenly.

    Parameters
    ----------
    settings : How samples are taken.
    samples : Number of postures; None takes that of the settings.
    max_pressure : Upper end of the box [Pa].
    start : Pressures that are applied now [Pa], shape (9,).
    period : Time between two updates [s].
    seed : Seed of the sequence of postures.
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
        sequence = qmc.Sobol(bellows.COUNT, scramble=True, seed=seed)
        exponent = max(1, int(np.ceil(np.log2(self.requested))))
        self._targets = max_pressure * sequence.random_base2(exponent)[: self.requested]
        self._output = np.array(start, dtype=np.float64)
        half = max(1, round(settings.rest_window / period))
        self._window: deque[Array] = deque(maxlen=2 * half)
        self._settled_for = 0.0
        self.elapsed = 0.0
        self._lengths: list[Array] = []

    @property
    def collected(self) -> int:
        """Number of settled postures so far."""
        return len(self._lengths)

    @property
    def done(self) -> bool:
        """Whether all postures are collected."""
        return self.collected == self.requested

    def samples(self) -> tuple[Array, Array]:
        """Lengths [m] and pressures [Pa] of the settled postures so far, both of shape (n, 9)."""
        lengths = np.array(self._lengths).reshape(-1, bellows.COUNT)
        return lengths, self._targets[: len(lengths)].copy()

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
        if self.done:
            return self._output
        target = self._targets[self.collected]
        step = self._settings.pressure_rate * self._period
        self._output = self._output + np.clip(target - self._output, -step, step)
        if not np.array_equal(self._output, target):
            self._window.clear()
            self._settled_for = 0.0
            return self._output
        self._window.append(lengths)
        self._settled_for += self._period
        if self._at_rest():
            half = self._window.maxlen // 2 if self._window.maxlen else 1
            self._lengths.append(np.mean(list(self._window)[half:], axis=0))
            self._window.clear()
            self._settled_for = 0.0
        return self._output

    def _at_rest(self) -> bool:
        if len(self._window) != self._window.maxlen:
            return False
        if self._settled_for >= self._settings.max_settling:
            return True
        half = len(self._window) // 2
        window = np.array(self._window)
        moved = np.abs(window[half:].mean(axis=0) - window[:half].mean(axis=0)).max()
        return bool(moved < self._settings.rest_speed * self._settings.rest_window)
