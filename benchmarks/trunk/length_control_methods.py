"""What the table `bha-control` compares: ways to bring the bellows to commanded lengths."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics
from bha_pressure_ctrl.command_shaping import ShapingSettings
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from bha_pressure_ctrl.length_controller import LengthController, LengthControllerSettings

Array = NDArray[np.float64]

PERIOD = 0.02


class Controller(Protocol):
    """Commanded and measured lengths [m] to pressures [Pa], all of shape (9,)."""

    def update(self, command: Array, lengths: Array) -> Array:
        """Compute the pressures for the next control period."""
        ...


@dataclass
class Pid:
    """PI control of every bellows by itself, without a model, the integral never forgotten.

    It has no derivative part: six choices of one (2e4 to 1e5 Pa s/m, filtered over 0.05 s) were
    unstable at twice the gain, beside 4e5 and 2.5e6, which is stable there without it.
    """

    proportional: float  # [Pa/m]
    integral: float  # [Pa/(m s)]

    def __post_init__(self) -> None:
        self._sum = np.full(bellows.COUNT, 0.5 * bellows.MAX_PRESSURE)

    def update(self, command: Array, lengths: Array) -> Array:
        """Compute the pressures for the next control period."""
        error = command - lengths
        total = self._sum + self.integral * PERIOD * error
        wanted = self.proportional * error + total
        pressures: Array = np.clip(wanted, 0.0, bellows.MAX_PRESSURE)
        self._sum = np.where((wanted - pressures) * error > 0.0, self._sum, total)
        return pressures


FASTEST_PID = (5e5, 2.5e6)
"""Of 36 pairs (1e5 to 6e5, 8e5 to 3e6), the one that brings all nine lengths within 2 mm soonest,
among those that stay stable on robots 0 to 7 with all gains doubled
(`benchmarks.scripts.pid_grid`).
"""

CAREFUL_PID = (5e5, 1.6e6)
"""The same among pairs whose largest overshoot is at most 1 mm in the median step."""


def controller(method: str, model: EquilibriumModel, gain: float = 1.0) -> Controller:
    """Make a controller; `gain` multiplies its feedback, not what it has learned."""
    if method in PIDS:
        proportional, integral = PIDS[method]
        return Pid(gain * proportional, gain * integral)
    settings = LengthControllerSettings()
    shaping = ShapingSettings()
    if method == PRESSURE_ONLY:
        gain = 0.0
    if method == AS_BEFORE:
        settings = LengthControllerSettings(3e5, 8e5, carry_distance=0.0)
        shaping = ShapingSettings(0.0, 0.0)
        model = replace(model, dynamics=BellowsDynamics(response_lag=0.0))
    settings = replace(
        settings,
        proportional_gain=gain * settings.proportional_gain,
        integral_gain=gain * settings.integral_gain,
    )
    return LengthController(
        model, settings, shaping, max_pressure=bellows.MAX_PRESSURE, period=PERIOD
    )


PRESSURE_ONLY, LEARNED = "pressure only", "learned + low gain"
AS_BEFORE = "learned + low gain, unshaped"
PID_FAST, PID_CAREFUL = "PID only, fastest", "PID only, overshoot <= 1 mm"
PIDS = {PID_FAST: FASTEST_PID, PID_CAREFUL: CAREFUL_PID}
METHODS = (PRESSURE_ONLY, PID_FAST, PID_CAREFUL, AS_BEFORE, LEARNED)
