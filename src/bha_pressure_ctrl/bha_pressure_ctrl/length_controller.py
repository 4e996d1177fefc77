"""Holds the bellows at commanded lengths: learned feed-forward plus low-gain feedback."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.settings import check_settings, setting
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LengthControllerSettings:
    """Gains of the feedback on the lengths, and the response it expects of the feed-forward."""

    proportional_gain: float = setting(4e5, "Pressure per length error [Pa/m]", low=0.0, high=2e6)
    integral_gain: float = setting(
        2e6, "Pressure per integrated length error [Pa/(m s)]", low=0.0, high=5e6
    )
    response_time: float = setting(
        0.35, "Time constant with which the lengths are to follow a command [s]", low=0.0, high=10.0
    )
    dead_time: float = setting(
        0.06, "Time until the lengths begin to follow a command [s]", low=0.0, high=1.0
    )
    adaptation_time: float = setting(
        120.0, "Time in which the model takes over what the integral holds; 0: never [s]", low=0.0
    )

    def __post_init__(self) -> None:
        check_settings(self)


class LengthController:
    """Equilibrium-point control of the lengths.

    ``pressures = model(command) + Kp (expected - lengths) + Ki integral(expected - lengths)``

    clipped to the range of the pressures. ``expected`` is the command after a dead time and a lag
    of first order: what the feed-forward is expected to bring by itself. So a new command finds no
    error, and the integral does not wind up while the feed-forward is at work. The integral stands
    for what the model does not know (creep, hysteresis, drift), so it is kept from one command to
    the next; where a pressure is at an end of its range and the error would push it further, its
    integral stands still.

    Near the command the model slowly takes over what the integral holds: it ages with the robot.

    Parameters
    ----------
    model : Inverse equilibrium model.
    settings : Gains.
    max_pressure : Upper end of the range of pressures [Pa]; the lower end is 0.
    period : Time between two updates [s].
    """

    SETTLED = 0.003
    """Distance of a length from its command within which the model adapts [m]."""

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
        self._follow = 1.0
        if settings.response_time > 0.0:
            self._follow = -float(np.expm1(-period / settings.response_time))
        self._delay = round(settings.dead_time / period)
        self._take_over = 0.0
        if settings.adaptation_time > 0.0:
            self._take_over = -float(np.expm1(-period / settings.adaptation_time))
        self._learned = np.zeros(bellows.COUNT)
        self.reset()

    @property
    def model(self) -> EquilibriumModel:
        """The model as of now, with what was learned since."""
        return self._model.shifted(self._learned) if self._learned.any() else self._model

    def reset(self) -> None:
        """Forget the integral and the command; what the model has taken over stays."""
        self._integral = np.zeros(bellows.COUNT)
        self._command: Array | None = None
        self._waiting: deque[Array] = deque()
        self._expected: Array | None = None
        self._feedforward = np.zeros(bellows.COUNT)

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
            self._feedforward = self.model.pressures(command)
        error = self._expect(command, lengths) - lengths
        integral = self._integral + (self._settings.integral_gain * self._period) * error
        wanted = self._feedforward + self._settings.proportional_gain * error + integral
        pressures = np.clip(wanted, 0.0, self._max_pressure)
        # Conditional integration, the anti-windup of Astrom and Hagglund, PID Controllers, 3.5.
        pushes_out = (wanted - pressures) * error > 0.0
        self._integral = np.where(pushes_out, self._integral, integral)
        self._adapt((np.abs(command - lengths) < self.SETTLED) & (wanted == pressures))
        return pressures

    def _expect(self, command: Array, lengths: Array) -> Array:
        """Advance what the lengths are expected to be."""
        if self._expected is None:
            self._expected = lengths
            self._waiting.extend([lengths] * self._delay)
        self._waiting.append(command)
        delayed = self._waiting.popleft()
        self._expected = self._expected + self._follow * (delayed - self._expected)
        return self._expected

    def _adapt(self, settled: NDArray[np.bool_]) -> None:
        """Let the model take over a little of the integral; the pressures stay as they are."""
        share = np.where(settled, self._take_over * self._integral, 0.0)
        self._learned = self._learned + share
        self._feedforward = self._feedforward + share
        self._integral = self._integral - share
