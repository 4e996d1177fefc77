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
MODELS = ("local_linear_maps", "recursive_maps")
FORWARD_MODELS = ("none", "polynomial")


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
    model : str
        "local_linear_maps": a gradient step on the blend, as in the literature, or
        "recursive_maps": recursive least squares a map (see `rls`).
    goal_candidates : int
        Of as many random goals the one with the largest last error comes next.
    abort_distance : float or None
        Distance between target and outcome at which a path is given up and the next one starts at
        what was observed [outcome unit]; None never gives up.
    stay_steps : int
        Steps for which a goal stays the target after a path has come to it, so that a robot which
        lags behind gets there.
    rest_steps : int
        As many steps for a goal that was met before; it is rested at without noise.
    rest_error : float
        Last error of a goal below which it counts as met [outcome unit]; 0 rests at none.
    noise_per_error : float or None
        Amplitude of the noise per last error of the goal [action unit per outcome unit], not above
        `noise_spread`; None for `noise_spread` always.
    noise_floor : float
        Smallest amplitude of the noise where `noise_per_error` is set [action unit].
    final_map_distance : float or None
        What the reach of new recursive maps shrinks to [outcome unit]; None for `map_distance`.
    shrink_samples : float
        Number of samples n0 in map_distance / sqrt(1 + n / n0), the reach after n samples.
    covariance : float
        Variance of the parameters of a new recursive map, in that of an example of weight 1: how
        far an example may draw a new map away from what its neighbours said.
    covariance_limit : float
        Largest variance of a parameter of a recursive map, in the same unit.
    process_noise : float
        Variance that an example of weight 1 adds to the parameters of a recursive map, in the same
        unit: 0 ends in plain least squares, a larger one follows a robot that changes.
    blend_samples : float
        Number of samples after which recursive maps learn what their blend misses.
    forward_model : str
        "polynomial" learns a forward model of the examples as well, and refines with it what the
        inverse model answers (see `BodyModel`); "none", as in the literature, does not.
    outcome_noise : float
        Standard deviation of an entry of the outcome that no action explains: what the forward
        model takes an example for [outcome unit].
    offset_spread : float
        Standard deviation of what a sensor of the actions is off by, as it wanders [action unit];
        0 for sensors that are not off. Only with a forward model.
    offset_samples : float
        Number of samples in which such an offset changes by about its spread.
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
    model: str = "local_linear_maps"
    goal_candidates: int = 1
    abort_distance: float | None = None
    stay_steps: int = 0
    rest_steps: int = 0
    rest_error: float = 0.0
    noise_per_error: float | None = None
    noise_floor: float = 0.0
    final_map_distance: float | None = None
    shrink_samples: float = 500.0
    covariance: float = 4.0
    covariance_limit: float = 10.0
    process_noise: float = 0.15
    blend_samples: float = 1000.0
    forward_model: str = "none"
    outcome_noise: float = 0.005
    offset_spread: float = 0.0
    offset_samples: float = 1000.0

    def __post_init__(self) -> None:
        """Check every setting.

        Raises
        ------
        InvalidConfigError
            Naming the setting, its value, and what would be right.
        """
        for name in (
            "map_distance",
            "learning_rate",
            "action_scale",
            "outcome_scale",
            "shrink_samples",
            "covariance",
            "covariance_limit",
            "outcome_noise",
            "offset_samples",
        ):
            self._check_number(name, lambda value: value > 0, "above 0")
        for name in (
            "noise_spread",
            "noise_step",
            "noise_floor",
            "action_resolution",
            "outcome_resolution",
            "process_noise",
            "blend_samples",
            "offset_spread",
            "rest_error",
        ):
            self._check_number(name, lambda value: value >= 0, "0 or above")
        self._check_number("home_probability", lambda value: 0 <= value <= 1, "in 0 to 1")
        for name in (
            "efficiency_limit",
            "abort_distance",
            "noise_per_error",
            "final_map_distance",
        ):
            if getattr(self, name) is not None:
                self._check_number(name, lambda value: value > 0, "above 0, or null")
        for name in ("path_steps", "error_window", "goal_candidates"):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < 1:
                raise InvalidConfigError(f"{name} must be a whole number above 0, got {value!r}")
        for name in ("stay_steps", "rest_steps"):
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < 0:
                raise InvalidConfigError(
                    f"{name} must be a whole number, 0 or above, got {value!r}"
                )
        for name, choices in (
            ("noise_origin", NOISE_ORIGINS),
            ("direction", DIRECTIONS),
            ("efficiency", EFFICIENCIES),
            ("model", MODELS),
            ("forward_model", FORWARD_MODELS),
        ):
            if getattr(self, name) not in choices:
                raise InvalidConfigError(
                    f"{name} must be one of {', '.join(choices)}, got {getattr(self, name)!r}"
                )

    @property
    def monitors_goals(self) -> bool:
        """Whether any setting asks for the errors of single goals."""
        return (
            self.goal_candidates > 1
            or self.abort_distance is not None
            or self.stay_steps > 0
            or self.rest_error > 0
            or self.noise_per_error is not None
        )

    @classmethod
    def rls(cls, **settings: Any) -> "GoalBabblerConfig":
        """Return the settings of RLS goal babbling for planar arms of 1 m, with some changed.

        Recursive least squares a map learns more from an example than a gradient step does, so
        exploration can be bolder as well: short paths that are given up early, white noise as
        strong as the goal's error, and goals that were missed more often.

        Parameters
        ----------
        **settings
            Settings that differ, by name.
        """
        recipe: dict[str, Any] = {
            "model": "recursive_maps",
            "map_distance": 0.1,
            "final_map_distance": 0.05,
            "noise_spread": 0.03,
            "noise_step": 0.1,
            "noise_per_error": 0.3,
            "noise_floor": 0.005,
            "path_steps": 5,
            "goal_candidates": 3,
            "abort_distance": 0.1,
            "efficiency": "relative",
        }
        return cls(**{**recipe, **settings})

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
