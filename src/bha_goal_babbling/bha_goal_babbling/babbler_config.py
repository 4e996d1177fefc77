"""The settings of goal babbling, under their names in the literature."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bha_goal_babbling.errors import InvalidConfigError

NOISE_ORIGINS = ("zero", "home")
DIRECTIONS = ("plain", "none")
EFFICIENCIES = ("plain", "relative", "none")


@dataclass(frozen=True)
class GoalBabblerConfig:
    """Settings of a `GoalBabbler`; the defaults suit planar arms of 1 m with 2 to 50 joints.

    Actions and outcomes have units of their own: rad and m on an arm, m and m on the trunk. The
    learner divides actions by `action_scale` and outcomes by `outcome_scale`. Both at 1 gives the
    formulas of the literature to the letter; set to the size of the ranges they make the
    efficiency w_eff, and with it the effect of `learning_rate`, independent of the units.

    `learning_rate`, `noise_step` and `map_distance` belong together: fresh noise (`noise_step` of
    `noise_spread` or above) keeps a learning rate near 1 stable, small maps need a large one.

    Attributes
    ----------
    map_distance : float
        Reach d of a local linear map and distance at which a new one is made [outcome unit].
    learning_rate : float
        Step eta of the gradient, unit-free.
    noise_spread : float
        Standard deviation s of the entries of the exploratory noise [action unit].
    noise_step : float
        Standard deviation sd of the noise's random walk a step [action unit], absolute.
    noise_origin : str
        Where the noise A x* + c has its origin: "zero" (the outcome 0, as in the literature) or
        "home" (the home outcome; right where the origin lies far outside of all goals).
    path_steps : int
        Steps L of a movement, of those towards home as well.
    home_probability : float
        Chance that a movement goes home instead of to a goal.
    action_scale : float
        Size of actions [action unit].
    outcome_scale : float
        Size of outcomes [outcome unit].
    direction : str
        "plain": w_dir, or "none": 1 for every example, which shows what w_dir is good for.
    efficiency : str
        "plain": w_eff in scaled units, "relative": w_eff divided by its own running mean, or
        "none": 1 for every example that moved the action, which shows what w_eff is good for.
    efficiency_limit : float or None
        Largest efficiency that counts; None for no limit.
    action_resolution : float
        Steps of the action not longer than this are sensor noise and not learned [action unit].
    outcome_resolution : float
        Steps of the outcome not longer than this have no direction [outcome unit].
    error_window : int
        Number of movements over which `GoalBabbler.recent_error` looks back.
    """

    map_distance: float = 0.07
    learning_rate: float = 1.0
    noise_spread: float = 0.03
    noise_step: float = 0.03
    noise_origin: str = "zero"
    path_steps: int = 25
    home_probability: float = 0.1
    action_scale: float = 1.0
    outcome_scale: float = 1.0
    direction: str = "plain"
    efficiency: str = "plain"
    efficiency_limit: float | None = None
    action_resolution: float = 0.0
    outcome_resolution: float = 0.0
    error_window: int = 20

    def __post_init__(self) -> None:
        """Check every setting.

        Raises
        ------
        InvalidConfigError
            Naming the setting, its value, and what would be right.
        """
        for name in ("map_distance", "learning_rate", "action_scale", "outcome_scale"):
            self._check_number(name, lambda value: value > 0, "above 0")
        for name in ("noise_spread", "noise_step", "action_resolution", "outcome_resolution"):
            self._check_number(name, lambda value: value >= 0, "0 or above")
        self._check_number("home_probability", lambda value: 0 <= value <= 1, "in 0 to 1")
        if self.efficiency_limit is not None:
            self._check_number("efficiency_limit", lambda value: value > 0, "above 0, or null")
        for name in ("path_steps", "error_window"):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < 1:
                raise InvalidConfigError(f"{name} must be a whole number above 0, got {value!r}")
        for name, choices in (
            ("noise_origin", NOISE_ORIGINS),
            ("direction", DIRECTIONS),
            ("efficiency", EFFICIENCIES),
        ):
            if getattr(self, name) not in choices:
                raise InvalidConfigError(
                    f"{name} must be one of {', '.join(choices)}, got {getattr(self, name)!r}"
                )

    @classmethod
    def from_mapping(cls, settings: Mapping[str, Any]) -> "GoalBabblerConfig":
        """Return the config with these settings, the rest at their defaults.

        Raises
        ------
        InvalidConfigError
            If a name is unknown (the message lists the valid ones) or a value is out of range.
        """
        names = [field.name for field in dataclasses.fields(cls)]
        unknown = sorted(str(name) for name in settings if name not in names)
        if unknown:
            raise InvalidConfigError(
                f"unknown setting {', '.join(unknown)}; valid are {', '.join(names)}"
            )
        return cls(**settings)

    def as_mapping(self) -> dict[str, Any]:
        """Return all settings by name, as `from_mapping` takes them."""
        return dataclasses.asdict(self)

    def _check_number(self, name: str, fits: Any, wanted: str) -> None:
        value = getattr(self, name)
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if not (number and math.isfinite(value) and fits(value)):
            raise InvalidConfigError(f"{name} must be a finite number {wanted}, got {value!r}")
