"""What the pressure controller does at every control period: control, identify, or be safe."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.command_gate import SafetySettings
from bha_common.settings import check_settings, setting
from bha_pressure_ctrl.command_shaping import ShapingSettings
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from bha_pressure_ctrl.identification import Identification, IdentificationSettings
from bha_pressure_ctrl.identified_model import fit_identified_model
from bha_pressure_ctrl.length_controller import LengthController, LengthControllerSettings
from bha_pressure_ctrl.model_fitting import ModelSettings

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PressureControlSettings:
    """Everything that can be set about the pressure controller."""

    control_period: float = setting(
        0.02, "Time between two states of the robot [s]", low=1e-3, high=1.0
    )
    seed: int = setting(
        0, "Seed of the postures that identification visits, and of the model's neurons", low=0
    )
    gains: LengthControllerSettings = field(default_factory=LengthControllerSettings)
    shaping: ShapingSettings = field(default_factory=ShapingSettings)
    identification: IdentificationSettings = field(default_factory=IdentificationSettings)
    model: ModelSettings = field(default_factory=ModelSettings)
    safety: SafetySettings = field(default_factory=lambda: SafetySettings(command_timeout=2.0))

    def __post_init__(self) -> None:
        check_settings(self)


class PressureControl:
    """Turns lengths into pressures, one control period after the other.

    Without a model, without a fresh command, and under the emergency stop, it goes to the safe
    state of its settings; it never guesses.

    Parameters
    ----------
    settings : Gains, limits and timeouts.
    model : Inverse equilibrium model; None when none is known yet.
    """

    NO_MODEL, SILENT, STOPPED = "no model", "no command", "stopped"
    CONTROL, IDENTIFY = "control", "identify"

    def __init__(
        self, settings: PressureControlSettings, model: EquilibriumModel | None = None
    ) -> None:
        self._settings = settings
        self._output = np.zeros(bellows.COUNT)
        self._command: Array | None = None
        self._command_time = -np.inf
        self._stopped = False
        self._identification: Identification | None = None
        self.mode = self.NO_MODEL
        self.use(model)

    @property
    def model(self) -> EquilibriumModel | None:
        """The model in use, with what it has learned since it was fitted or loaded."""
        return self._model if self._controller is None else self._controller.model

    @property
    def stopped(self) -> bool:
        """Whether the emergency stop is active."""
        return self._stopped

    @property
    def identification(self) -> Identification | None:
        """The identification that runs; None when none does."""
        return self._identification

    def use(self, model: EquilibriumModel | None) -> None:
        """Replace the model in use."""
        self._model = model
        self._controller = (
            None
            if model is None
            else LengthController(
                model,
                self._settings.gains,
                self._settings.shaping,
                max_pressure=self._settings.safety.max_pressure,
                period=self._settings.control_period,
            )
        )

    def command(self, time: float, lengths: Array) -> None:
        """Take a valid length command.

        Parameters
        ----------
        time : Robot time of the command [s].
        lengths : Lengths to reach [m], shape (9,), finite; clipped to what can be meant.
        """
        if not self._stopped:
            self._command = np.clip(lengths, bellows.MIN_LENGTH, bellows.MAX_LENGTH)
            self._command_time = time

    def stop(self, stopped: bool) -> None:
        """Begin or end the emergency stop; the command in force is forgotten either way."""
        self._stopped = stopped
        self._command = None
        self._identification = None

    def begin_anew(self) -> None:
        """Take the robot for a fresh one, vented: nothing of before is to come back to it."""
        self._command = None
        self._identification = None
        self._output = np.zeros(bellows.COUNT)
        self.use(self._model)

    def identify(self, samples: int | None = None) -> Identification:
        """Begin to collect samples; `finish_identification` ends it.

        Raises
        ------
        RuntimeError
            When identification runs already, or the emergency stop is active.
        """
        if self._stopped:
            raise RuntimeError("the emergency stop is active: reset it first")
        if self._identification is not None:
            raise RuntimeError("identification is running already")
        self._identification = Identification(
            self._settings.identification,
            max_pressure=self._settings.safety.max_pressure,
            start=self._output,
            period=self._settings.control_period,
            seed=self._settings.seed,
            samples=samples,
        )
        return self._identification

    def abandon_identification(self) -> None:
        """End identification and keep the model in use."""
        self._end_identification()

    def finish_identification(self) -> EquilibriumModel:
        """Fit a model to the samples collected, and use it.

        Raises
        ------
        EquilibriumModelError
            When no model can be fitted; the model in use stays.
        RuntimeError
            When no identification runs.
        """
        identification = self._end_identification()
        if identification is None:
            raise RuntimeError("no identification is running")
        settings = self._settings
        model = fit_identified_model(
            identification,
            settings.model,
            period=settings.control_period,
            max_pressure=settings.safety.max_pressure,
            seed=settings.seed,
        )
        self.use(model)
        return model

    def _end_identification(self) -> Identification | None:
        """Return the identification that ran; control begins afresh where that left the robot."""
        identification, self._identification = self._identification, None
        if identification is not None and self._controller is not None:
            self._controller.reset()
        return identification

    def update(self, time: float, lengths: Array) -> Array:
        """Compute the pressures for the next control period.

        Parameters
        ----------
        time : Robot time of the lengths [s].
        lengths : Measured lengths [m], shape (9,).

        Returns
        -------
        Pressures [Pa], shape (9,), within the range.
        """
        self.mode = self._choose_mode(time)
        if self.mode == self.IDENTIFY and self._identification is not None:
            self._output = self._identification.update(lengths)
        elif self.mode == self.CONTROL and self._controller is not None:
            assert self._command is not None
            self._output = self._controller.update(self._command, lengths)
        else:
            self._go_safe()
        return self._output

    def _choose_mode(self, time: float) -> str:
        safety = self._settings.safety
        if time - self._command_time > safety.command_timeout + 0.5 * self._settings.control_period:
            self._command = None
        if self._stopped:
            return self.STOPPED
        if self._identification is not None:
            return self.IDENTIFY
        if self._controller is None:
            return self.NO_MODEL
        return self.SILENT if self._command is None else self.CONTROL

    def _go_safe(self) -> None:
        if self._controller is not None:
            self._controller.reset()
        safety = self._settings.safety
        if safety.safe_state == "vent":
            step = safety.vent_rate * self._settings.control_period
            self._output = np.maximum(self._output - step, 0.0)
