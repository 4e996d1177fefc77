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
from bha_sim.compiled import compiled
from bha_sim.disturbances import Disturbances
from bha_sim.parameter_checks import Array
from bha_sim.parameter_sections import PotentiometerParameters


@dataclass(frozen=True)
class PotentiometerState:
    """Everything that `Potentiometers` remember; opaque to others."""

    cables: Array
    drift: Array
    departures: Array
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
        self._gains, self._offsets = parameters.gains, parameters.offsets
        self._noise, self._resolution = parameters.noise, parameters.resolution
        self._drift_spread = parameters.drift_spread
        self._half_play = 0.5 * parameters.play
        self._keep = math.exp(-period / parameters.drift_time)
        self._kick = parameters.drift_spread * math.sqrt(1.0 - self._keep**2)
        self._cables = np.empty(bellows.COUNT)
        self._drift = np.empty(bellows.COUNT)
        self._normals = np.empty((2, bellows.COUNT))
        self._period = period
        # What a disturbance adds to the readings: a shift, and a drift that grows.
        self._departures = np.zeros(bellows.COUNT)
        self.disturb(Disturbances())
        self.reset(seed, lengths)

    def reset(self, seed: np.random.SeedSequence, lengths: Array) -> None:
        """Start anew at `lengths` [m], shape (9,), with noise and drift from `seed`."""
        self._rng = np.random.default_rng(seed)
        self._cables[:] = lengths
        self._drift[:] = self._drift_spread * self._rng.standard_normal(bellows.COUNT)
        self._departures[:] = 0.0

    def disturb(self, disturbances: Disturbances) -> None:
        """Take on shifts and drifts, from the next reading on; where a drift ends, it is gone."""
        self._shift = np.array(disturbances.sensor_shift)
        self._departure = self._period * np.array(disturbances.sensor_drift)
        self._departures[self._departure == 0.0] = 0.0

    def measure(self, lengths: Array, out: Array) -> None:
        """Let one period pass and read.

        Parameters
        ----------
        lengths : True lengths [m], shape (9,).
        out : Filled with the measured lengths [m], shape (9,).
        """
        self._rng.standard_normal(out=self._normals)
        _read(
            lengths,
            self._normals,
            self._half_play,
            self._keep,
            self._kick,
            self._noise,
            self._resolution,
            self._gains,
            self._offsets,
            self._cables,
            self._drift,
            self._shift,
            self._departure,
            self._departures,
            out,
        )

    @property
    def state(self) -> PotentiometerState:
        """Copy of everything needed to go on from here."""
        return PotentiometerState(
            self._cables.copy(),
            self._drift.copy(),
            self._departures.copy(),
            self._rng.bit_generator.state,
        )

    @state.setter
    def state(self, value: PotentiometerState) -> None:
        self._cables[:] = value.cables
        self._drift[:] = value.drift
        self._departures[:] = value.departures
        self._rng.bit_generator.state = value.generator


@compiled
def _read(
    lengths: Array,
    normals: Array,
    half_play: float,
    keep: float,
    kick: float,
    noise: float,
    resolution: float,
    gains: Array,
    offsets: Array,
    cables: Array,
    drift: Array,
    shift: Array,
    departure: Array,
    departures: Array,
    out: Array,
) -> None:
    """Advance cables and drift by one period, and fill `out` with the readings."""
    for index in range(len(lengths)):
        length = lengths[index]
        cables[index] = min(max(cables[index], length - half_play), length + half_play)
        drift[index] = keep * drift[index] + kick * normals[0, index]
        departures[index] += departure[index]
        reading = gains[index] * cables[index] + offsets[index] + drift[index]
        reading += shift[index] + departures[index]
        reading += noise * normals[1, index]
        if resolution > 0.0:
            reading = np.rint(reading / resolution) * resolution
        out[index] = reading
