"""From commanded pressures to the pressures in the bellows, and their sensors.

A command waits for the dead time, meets the play of the regulator (a backlash: the set-point
follows only when the command leaves the play), and fills or vents the bellows through a first-order
lag: p <- s + (p - s) exp(-dt/tau), exact for a set-point s that holds during the period.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from bha_common import bellows

from bha_sim.parameter_sections import Array, PneumaticParameters


@dataclass(frozen=True)
class PneumaticState:
    """Everything that `Pneumatics` remembers; opaque to others."""

    waiting: Array
    setpoints: Array
    pressures: Array
    generator: Mapping[str, Any]


class Pneumatics:
    """Valves, hoses and pressure sensors of all bellows.

    Parameters
    ----------
    parameters : Their physical numbers.
    period : Time for which a command holds [s]; the dead time is rounded to a multiple of it.
    seed : Seeds the sensors' noise.
    """

    def __init__(
        self, parameters: PneumaticParameters, period: float, seed: np.random.SeedSequence
    ) -> None:
        self._parameters = parameters
        self._dead_periods = round(parameters.dead_time / period)
        self._fill = -np.expm1(-period / parameters.fill_time_constant)
        self._vent = -np.expm1(-period / parameters.vent_time_constant)
        self._half_play = 0.5 * parameters.regulator_play
        self.pressures: Array = np.zeros(bellows.COUNT)
        """Pressures in the bellows [Pa], shape (9,); changed in place by `step`."""
        self.reset(seed)

    def reset(self, seed: np.random.SeedSequence) -> None:
        """Vent everything at once and seed the noise anew."""
        self._waiting = np.zeros((self._dead_periods, bellows.COUNT))
        self._setpoints = np.zeros(bellows.COUNT)
        self.pressures[:] = 0.0
        self._rng = np.random.default_rng(seed)

    def step(self, command: Array) -> Array:
        """Advance by one period.

        Parameters
        ----------
        command : Commanded pressures [Pa], shape (9,), within the range.

        Returns
        -------
        Pressures in the bellows at the end of the period [Pa], shape (9,): `pressures` itself.
        """
        if self._dead_periods:
            arrived = self._waiting[0].copy()
            self._waiting[:-1] = self._waiting[1:]
            self._waiting[-1] = command
        else:
            arrived = command
        low, high = arrived - self._half_play, arrived + self._half_play
        setpoints = np.minimum(np.maximum(self._setpoints, low), high)
        # A regulator does not stay short of an end of its range: at zero it vents fully.
        setpoints[arrived <= 0.0] = 0.0
        self._setpoints = setpoints
        gap = setpoints - self.pressures
        self.pressures += np.where(gap > 0.0, self._fill, self._vent) * gap
        return self.pressures

    def measure(self) -> Array:
        """Read the pressure sensors [Pa], shape (9,)."""
        noise, step = self._parameters.sensor_noise, self._parameters.sensor_resolution
        reading = self.pressures + noise * self._rng.standard_normal(bellows.COUNT)
        return np.rint(reading / step) * step if step else reading

    @property
    def state(self) -> PneumaticState:
        """Copy of everything needed to go on from here."""
        return PneumaticState(
            self._waiting.copy(),
            self._setpoints.copy(),
            self.pressures.copy(),
            self._rng.bit_generator.state,
        )

    @state.setter
    def state(self, value: PneumaticState) -> None:
        self._waiting = value.waiting.copy()
        self._setpoints = value.setpoints.copy()
        self.pressures[:] = value.pressures
        self._rng.bit_generator.state = value.generator
