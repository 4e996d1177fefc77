"""Holds the bellows at commanded lengths: learned feed-forward plus low-gain feedback."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.settings import check_settings, setting
from bha_pressure_ctrl.command_shaping import CommandShaping, ShapingSettings
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel

Array = NDArray[np.float64]

_SHORT_SHARE = 0.1  # of the way to a new command, up to the shortfall: none where it moves slowly
_SHORT_TIME = 1.0  # [s]


@dataclass(frozen=True)
class LengthControllerSettings:
    """Gains of the feedback on the lengths."""

    proportional_gain: float = setting(4e5, "Pressure per length error [Pa/m]", low=0.0, high=2e6)
    integral_gain: float = setting(
        8e5, "Pressure per integrated length error [Pa/(m s)]", low=0.0, high=5e6
    )
    adaptation_time: float = setting(
        120.0, "Time in which the model takes over what the integral holds; 0: never [s]", low=0.0
    )
    carry_distance: float = setting(
        0.09,
        "Distance of a command from the one before, over all lengths, to which 1/e of the integral "
        "is carried; 0: all of it, anywhere [m]",
        low=0.0,
    )

    def __post_init__(self) -> None:
        check_settings(self)


class LengthController:
    """Equilibrium-point control of the lengths.

    ``pressures = feedforward + Kp (expected - lengths) + Ki integral(expected - lengths)``

    clipped to the range of the pressures. The feed-forward is the model's answer to the command and
    to what the bellows remember, brought on by `CommandShaping`, which also tells the lengths to
    expect of it. So a new command finds no error, and the integral does not wind up while the
    feed-forward is at work. It stands for what the model does not know of a posture and those near
    it, so less of it is carried to the next command the further away that is. Where a pressure is
    at an end of its range and the error would push it further, its integral stands still.

    What the feed-forward does not know of a step lets single bellows go too far or not far enough
    alike. A command is therefore approached from where it comes from: the lengths asked for fall
    short of it by `ShapingSettings.shortfall` at first.

    Near the command the model slowly takes over what the integral holds, for all postures: it ages
    with the robot.

    Parameters
    ----------
    model : Inverse equilibrium model.
    settings : Gains.
    shaping : How commands are brought on.
    max_pressure : Upper end of the range of pressures [Pa]; the lower end is 0.
    period : Time between two updates [s].
    """

    SETTLED = 0.003
    """Distance of a length from its command within which the model adapts [m]."""

    def __init__(
        self,
        model: EquilibriumModel,
        settings: LengthControllerSettings,
        shaping: ShapingSettings,
        *,
        max_pressure: float,
        period: float,
    ) -> None:
        self._model = model
        self._settings = settings
        self._how = shaping
        self._max_pressure = max_pressure
        self._period = period
        self._take_over = 0.0
        if settings.adaptation_time > 0.0:
            self._take_over = -float(np.expm1(-period / settings.adaptation_time))
        self._short_decay = float(np.exp(-period / _SHORT_TIME))
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
        self._short = np.zeros(bellows.COUNT)  # of the command at first [m]
        self._short_share = 0.0  # of that, by now
        self._targets = np.zeros((2, 2 * bellows.COUNT))
        self._shaping: CommandShaping | None = None

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
            self._carry_to(command)
            self._fall_short_of(command)
            self._command = command
        if self._shaping is None:
            self._shaping = CommandShaping(
                self._how,
                self._model.dynamics,
                period=self._period,
                lengths=lengths,
                pressures=self.model.pressures(lengths) - self._learned,
            )
        known = self._learned + self._integral
        there, short = self._targets
        target = there + self._short_share * (short - there)
        self._short_share *= self._short_decay
        shaped, expected = self._shaping.update(target, lengths, -known, self._max_pressure - known)
        error = expected - lengths
        integral = self._integral + (self._settings.integral_gain * self._period) * error
        wanted = shaped + self._learned + self._settings.proportional_gain * error + integral
        pressures = np.minimum(np.maximum(wanted, 0.0), self._max_pressure)
        # Conditional integration, the anti-windup of Astrom and Hagglund, PID Controllers, 3.5.
        pushes_out = (wanted - pressures) * error > 0.0
        self._integral = np.where(pushes_out, self._integral, integral)
        self._adapt((np.abs(command - lengths) < self.SETTLED) & (wanted == pressures))
        return pressures

    def _carry_to(self, command: Array) -> None:
        """Let go of what the integral has found elsewhere."""
        if self._command is not None and self._settings.carry_distance > 0.0:
            distance = float(np.linalg.norm(command - self._command))
            self._integral = self._integral * np.exp(-distance / self._settings.carry_distance)

    def _fall_short_of(self, command: Array) -> None:
        """Set out for a command, and for the lengths a little before it."""
        way = 0.0 if self._command is None else command - self._command
        most = self._how.shortfall
        short = self._short_share * self._short + _SHORT_SHARE * way
        self._short = np.minimum(np.maximum(short, -most), most)
        self._short_share = 1.0
        lengths = np.stack([command, command - self._short])
        # As the model would answer that is saved now; apart only beyond the ends of the range.
        self._targets = np.hstack([lengths, self.model.pressures(lengths) - self._learned])

    def _adapt(self, settled: NDArray[np.bool_]) -> None:
        """Let the model take over a little of the integral; their sum stays as it is."""
        share = np.where(settled, self._take_over * self._integral, 0.0)
        self._learned = self._learned + share
        self._integral = self._integral - share
