"""Holds the bellows at commanded lengths: learned feed-forward plus low-gain feedback."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.settings import check_settings, setting
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LengthControllerSettings:
    """Gains of the feedback on the lengths."""

    proportional_gain: float = setting(3e5, "Pressure per length error [Pa/m]", low=0.0, high=2e6)
    integral_gain: float = setting(
        8e5, "Pressure per integrated length error [Pa/(m s)]", low=0.0, high=5e6
    )

    def __post_init__(self) -> None:
        check_settings(self)


class LengthController:
    """Equilibrium-point control of the lengths.

    ``pressures = model(command) + Kp (command - lengths) + Ki integral(command - lengths)``

    clipped to the range of the pressures. The integral stands for what the model does not know
    (creep, hysteresis, drift), so it is kept from one command to the next. Where a pressure is at
    an end of its range and the error would push it further, its integral stands still.

    Parameters
    ----------
    model : Inverse equilibrium model.
    settings : Gains.
    max_pressure : Upper end of the range of pressures [Pa]; the lower end is 0.
    period : Time between two updates [s].
    """

    def __init__(
        self,
        model: EquilibriumModel,
        settings: LengthControllerSettings,
        *,
        max_pressure: float,
        period: float,
    ) -> None:
        self._model = model
        self._settings = settings
        self._max_pressure = max_pressure
        self._period = period
        self._integral = np.zeros(bellows.COUNT)
        self._command: Array | None = None
        self._feedforward = np.zeros(bellows.COUNT)

    def reset(self) -> None:
        """Forget the integral."""
        self._integral = np.zeros(bellows.COUNT)

    def update(self, command: Array, lengths: Array) -> Array:
        """Compute the pressures for the next control period.

        Parameters
        ----------
        command : Lengths to reach [m], shape (9,).
        lengths : Measured lengths [m], shape (9,).

        Returns
        -------
        Pressures [Pa], shape (9,), within the range.
        """
        if command is not self._command:
            self._command = command
            self._feedforward = self._model.pressures(command)
        error = command - lengths
        integral = self._integral + (self._settings.integral_gain * self._period) * error
        wanted = self._feedforward + self._settings.proportional_gain * error + integral
        pressures = np.clip(wanted, 0.0, self._max_pressure)
        # Conditional integration, the anti-windup of Astrom and Hagglund, PID Controllers, 3.5.
        pushes_out = (wanted - pressures) * error > 0.0
        self._integral = np.where(pushes_out, self._integral, integral)
        return pressures
