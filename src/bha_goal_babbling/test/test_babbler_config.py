"""Settings: ranges, names, messages."""

import dataclasses
from typing import Any

import pytest

from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.errors import InvalidConfigError


def test_round_trip() -> None:
    """A config is what its mapping says."""
    config = GoalBabblerConfig(map_distance=0.2, efficiency_limit=1.0, noise_origin="home")
    assert GoalBabblerConfig.from_mapping(config.as_mapping()) == config


def test_is_frozen() -> None:
    """Settings do not change under a learner."""
    with pytest.raises(dataclasses.FrozenInstanceError):
        GoalBabblerConfig().learning_rate = 2.0  # type: ignore[misc]


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("map_distance", 0.0),
        ("learning_rate", -0.1),
        ("learning_rate", "0.1"),
        ("noise_spread", float("nan")),
        ("noise_step", float("inf")),
        ("noise_step", None),
        ("home_probability", 1.1),
        ("path_steps", 0),
        ("path_steps", 2.5),
        ("path_steps", True),
        ("action_scale", 0),
        ("efficiency_limit", 0.0),
        ("efficiency", "off"),
        ("direction", "relative"),
        ("noise_origin", 0),
        ("action_resolution", -1e-3),
        ("error_window", 0),
        ("model", "elm"),
        ("goal_candidates", 0),
        ("abort_distance", 0.0),
        ("noise_per_error", -1.0),
        ("noise_floor", -0.1),
        ("final_map_distance", 0.0),
        ("shrink_samples", 0.0),
        ("covariance", 0.0),
        ("covariance_limit", 0.0),
        ("process_noise", -0.1),
        ("blend_samples", -1.0),
        ("stay_steps", -1),
        ("stay_steps", 1.0),
        ("stay_steps", True),
        ("rest_steps", -1),
        ("rest_steps", 1.0),
        ("rest_error", -0.1),
        ("rest_error", None),
        ("forward_model", None),
        ("forward_model", "linear"),
        ("outcome_noise", 0.0),
        ("offset_spread", -1e-3),
        ("offset_samples", 0.0),
    ],
)
def test_refuses_values_out_of_range(name: str, value: Any) -> None:
    """The message names the setting and the value."""
    with pytest.raises(InvalidConfigError, match=name) as caught:
        GoalBabblerConfig.from_mapping({name: value})
    assert repr(value) in str(caught.value)


def test_unknown_name_lists_the_valid_ones() -> None:
    """A misspelt name is not passed over."""
    with pytest.raises(InvalidConfigError, match=r"unknown setting eta; valid are .*learning_rate"):
        GoalBabblerConfig.from_mapping({"eta": 0.1})


def test_rls_is_a_recipe_that_can_be_changed() -> None:
    """It asks for recursive maps and for the errors of goals; the defaults ask for neither."""
    config = GoalBabblerConfig.rls(path_steps=7)
    assert (config.model, config.path_steps, config.monitors_goals) == ("recursive_maps", 7, True)
    assert GoalBabblerConfig.from_mapping(config.as_mapping()) == config
    assert not GoalBabblerConfig().monitors_goals
    with pytest.raises(InvalidConfigError, match="path_steps"):
        GoalBabblerConfig.rls(path_steps=0)
