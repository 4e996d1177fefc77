"""Cable potentiometers: what is measured of the bellows lengths.

The cable has play (a backlash: the reading follows only when the length leaves the play), the
electronics drift slowly (an Ornstein-Uhlenbeck process, exact from period to period), every reading
has white noise, and the converter has steps. Offset and gain belong to each robot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from bha_common import bellows

from bha_sim.parameter_sections import Array, PotentiometerParameters


@dataclass(frozen=True)
class PotentiometerState:
    """Everything that `Potentiometers` remember; opaque to others."""

    cables: Array
    drift: Array
    generator: Mapping[str, Any]


class Potentiometers:
    """The nine potentiometers of a robot.

    Parameters
    ----------
    parameters : Their physical numbers.
    period : Time between two readings [s].
    seed : Seeds noise and drift.
    lengths : Lengths at the start, in the middle of the play [m], shape (9,).
    """

    def __init__(
        self,
        parameters: PotentiometerParameters,
        period: float,
        seed: np.random.SeedSequence,
        lengths: Array,
    ) -> None:
        self._parameters = parameters
        self._half_play = 0.5 * parameters.play
        self._keep = math.exp(-period / parameters.drift_time)
        self._kick = parameters.drift_spread * math.sqrt(1.0 - self._keep**2)
        self.reset(seed, lengths)

    def reset(self, seed: np.random.SeedSequence, lengths: Array) -> None:
        """Start anew at `lengths` [m], shape (9,), with noise and drift from `seed`."""
        self._rng = np.random.default_rng(seed)
        self._cables = lengths.copy()
        self._drift = self._parameters.drift_spread * self._rng.standard_normal(bellows.COUNT)

    def measure(self, lengths: Array) -> Array:
        """Let one period pass and read.

        Parameters
        ----------
        lengths : True lengths [m], shape (9,).

        Returns
        -------
        Measured lengths [m], shape (9,).
        """
        parameters = self._parameters
        cables = np.maximum(self._cables, lengths - self._half_play)
        self._cables = np.minimum(cables, lengths + self._half_play)
        white, kicks = self._rng.standard_normal((2, bellows.COUNT))
        self._drift = self._keep * self._drift + self._kick * kicks
        reading = parameters.gains * self._cables + parameters.offsets + self._drift
        reading += parameters.noise * white
        step = parameters.resolution
        return np.rint(reading / step) * step if step else reading

    @property
    def state(self) -> PotentiometerState:
        """Copy of everything needed to go on from here."""
        return PotentiometerState(
            self._cables.copy(), self._drift.copy(), self._rng.bit_generator.state
        )

    @state.setter
    def state(self, value: PotentiometerState) -> None:
        self._cables = value.cables.copy()
        self._drift = value.drift.copy()
        self._rng.bit_generator.state = value.generator
