"""From commanded pressures to the pressures in the bellows, and their sensors.

A command waits for the dead time, meets the play of the regulator (a backlash: the set-point
follows only when the command leaves the play), and fills or vents the bellows through a first-order
lag: p <- s + (p - s) exp(-dt/tau), exact for a set-point s that holds during the period.

A leak to the atmosphere with c times the conductance of the valve makes that
p <- s/(1 + c) + (p - s/(1 + c)) exp(-(1 + c) dt/tau).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_sim.compiled import compiled
from bha_sim.disturbances import Disturbances
from bha_sim.parameter_checks import Array
from bha_sim.parameter_sections import PneumaticParameters


@dataclass(frozen=True)
class PneumaticState:
    """Everything that `Pneumatics` remembers; opaque to others."""

    waiting: Array
    oldest: int
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
        self._parameters, self._period = parameters, period
        self.disturb(Disturbances())
        self._half_play = 0.5 * parameters.regulator_play
        self._noise = parameters.sensor_noise
        self._resolution = parameters.sensor_resolution
        self._waiting = np.zeros((round(parameters.dead_time / period), bellows.COUNT))
        self._setpoints = np.zeros(bellows.COUNT)
        self.pressures: Array = np.zeros(bellows.COUNT)
        """Pressures in the bellows [Pa], shape (9,); changed in place by `step`."""
        self.reset(seed)

    def reset(self, seed: np.random.SeedSequence) -> None:
        """Vent everything at once and seed the noise anew."""
        self._waiting[:] = 0.0
        self._oldest = 0
        self._setpoints[:] = 0.0
        self.pressures[:] = 0.0
        self._rng = np.random.default_rng(seed)

    def disturb(self, disturbances: Disturbances) -> None:
        """Take on leaks, lost ranges and stuck valves, from the next period on."""
        top, period = self._parameters.max_pressure, self._period
        self._outflow = 1.0 + np.array(disturbances.leak)
        self._fill = -np.expm1(-period * self._outflow / self._parameters.fill_time_constant)
        self._vent = -np.expm1(-period * self._outflow / self._parameters.vent_time_constant)
        self._lowest = top * np.array(disturbances.range_lost_below)
        self._highest = top * (1.0 - np.array(disturbances.range_lost_above))
        self._stuck = np.array(disturbances.stuck_valves)

    def step(self, command: Array) -> Array:
        """Advance by one period.

        Parameters
        ----------
        command : Commanded pressures [Pa], shape (9,), within the range.

        Returns
        -------
        Pressures in the bellows at the end of the period [Pa], shape (9,): `pressures` itself.
        """
        self._oldest = _advance(
            command,
            self._waiting,
            self._oldest,
            self._half_play,
            self._fill,
            self._vent,
            self._outflow,
            self._lowest,
            self._highest,
            self._stuck,
            self._setpoints,
            self.pressures,
        )
        return self.pressures

    def measure(self, out: Array) -> None:
        """Read the pressure sensors.

        Parameters
        ----------
        out : Filled with the readings [Pa], shape (9,).
        """
        self._rng.standard_normal(out=out)
        _read(self.pressures, self._noise, self._resolution, out)

    @property
    def state(self) -> PneumaticState:
        """Copy of everything needed to go on from here."""
        return PneumaticState(
            self._waiting.copy(),
            self._oldest,
            self._setpoints.copy(),
            self.pressures.copy(),
            self._rng.bit_generator.state,
        )

    @state.setter
    def state(self, value: PneumaticState) -> None:
        self._waiting[:] = value.waiting
        self._oldest = value.oldest
        self._setpoints[:] = value.setpoints
        self.pressures[:] = value.pressures
        self._rng.bit_generator.state = value.generator


@compiled
def _advance(
    command: Array,
    waiting: Array,
    oldest: int,
    half_play: float,
    fill: Array,
    vent: Array,
    outflow: Array,
    lowest: Array,
    highest: Array,
    stuck: NDArray[np.bool_],
    setpoints: Array,
    pressures: Array,
) -> int:
    """Advance queue, regulators and bellows by one period; the new oldest row of the queue."""
    for index in range(len(command)):
        arrived = command[index]
        if len(waiting) > 0:
            arrived = waiting[oldest, index]
            waiting[oldest, index] = command[index]
        if not stuck[index]:
            setpoint = min(max(setpoints[index], arrived - half_play), arrived + half_play)
            if arrived <= 0.0:
                # A regulator does not stay short of the end of its range: at zero it vents fully.
                setpoint = 0.0
            setpoints[index] = min(max(setpoint, lowest[index]), highest[index])
        rate = fill[index] if setpoints[index] > pressures[index] else vent[index]
        pressures[index] += (setpoints[index] / outflow[index] - pressures[index]) * rate
    return (oldest + 1) % len(waiting) if len(waiting) > 0 else 0


@compiled
def _read(pressures: Array, noise: float, resolution: float, out: Array) -> None:
    """Turn standard normal numbers in `out` into readings."""
    for index in range(len(pressures)):
        reading = pressures[index] + noise * out[index]
        if resolution > 0.0:
            reading = np.rint(reading / resolution) * resolution
        out[index] = reading
