"""The model in the units of the robot: scales, weights, snapshots."""

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.local_linear_map import LocalLinearMaps
from bha_goal_babbling.scaled_model import ScaledModel

CONFIG = GoalBabblerConfig(map_distance=0.2, learning_rate=0.5)
HOME_ACTION, HOME_OUTCOME = np.array([0.1, 0.2, 0.3]), np.array([0.5, -0.2])


def example(rng: np.random.Generator) -> tuple[FloatArray, ...]:
    """Return an action, its outcome, both steps and an intended step."""
    action, outcome = rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 2)
    return action, outcome, rng.uniform(-1, 1, 3), rng.uniform(-1, 1, 2), rng.uniform(-1, 1, 2)


def test_begins_with_home_everywhere() -> None:
    model = ScaledModel.at_home(
        GoalBabblerConfig(action_scale=0.15, outcome_scale=0.45), HOME_ACTION, HOME_OUTCOME
    )
    np.testing.assert_allclose(model.predict(np.array([3.0, 4.0])), HOME_ACTION, rtol=1e-15)
    np.testing.assert_allclose(model.predict_many(np.zeros((4, 2))), [HOME_ACTION] * 4)
    assert model.model.count == 1


def test_scale_one_is_the_plain_formula() -> None:
    """The weighted step on the model itself, with w = w_dir w_eff."""
    scaled = ScaledModel.at_home(CONFIG, HOME_ACTION, HOME_OUTCOME)
    plain = LocalLinearMaps(0.2, 0.5, HOME_OUTCOME, HOME_ACTION)
    action, outcome = np.array([0.2, 0.2, 0.3]), np.array([0.55, -0.2])
    action_step, outcome_step = np.array([0.1, 0.0, 0.0]), np.array([0.05, 0.0])
    scaled.learn(action, outcome, action_step, outcome_step, np.array([0.0, 0.1]))
    plain.learn(outcome, action, 0.5 * 0.5)
    scaled.learn(action, outcome, action_step, outcome_step, None)
    plain.learn(outcome, action, 0.5)
    for x in np.random.default_rng(0).uniform(-1, 1, (10, 2)):
        np.testing.assert_allclose(scaled.predict(x), plain.predict(x), rtol=1e-12)


@pytest.mark.parametrize(("action_unit", "outcome_unit"), [(1e3, 1.0), (1.0, 1e3), (57.3, 1e-2)])
def test_units_do_not_matter_when_the_scales_follow(
    action_unit: float, outcome_unit: float
) -> None:
    """The same robot in other units learns the same, if d and the scales are in them too."""
    other = ScaledModel.at_home(
        GoalBabblerConfig(
            map_distance=0.2 * outcome_unit,
            learning_rate=0.5,
            action_scale=action_unit,
            outcome_scale=outcome_unit,
        ),
        action_unit * HOME_ACTION,
        outcome_unit * HOME_OUTCOME,
    )
    model, rng = ScaledModel.at_home(CONFIG, HOME_ACTION, HOME_OUTCOME), np.random.default_rng(1)
    for _ in range(300):
        q, x, dq, dx, dt = example(rng)
        model.learn(q, x, dq, dx, dt)
        other.learn(
            action_unit * q,
            outcome_unit * x,
            action_unit * dq,
            outcome_unit * dx,
            outcome_unit * dt,
        )
    xs = rng.uniform(-1, 1, (20, 2))
    expected = model.predict_many(xs)
    np.testing.assert_allclose(
        other.predict_many(outcome_unit * xs) / action_unit, expected, rtol=1e-8, atol=1e-8
    )


def test_recursive_maps_with_relative_weights_need_no_scales() -> None:
    """Weights without a unit leave nothing that depends on the unit of actions or outcomes."""
    settings = {"model": "recursive_maps", "efficiency": "relative"}
    model = ScaledModel.at_home(
        GoalBabblerConfig(map_distance=0.2, **settings), HOME_ACTION, HOME_OUTCOME
    )
    other = ScaledModel.at_home(
        GoalBabblerConfig(map_distance=200.0, action_scale=1.0, **settings),
        57.3 * HOME_ACTION,
        1e3 * HOME_OUTCOME,
    )
    other._weights._mean *= 1e3 / 57.3  # the guess that the mean starts with has the plain unit
    rng = np.random.default_rng(1)
    for _ in range(300):
        q, x, dq, dx, dt = example(rng)
        model.learn(q, x, dq, dx, dt)
        other.learn(57.3 * q, 1e3 * x, 57.3 * dq, 1e3 * dx, 1e3 * dt)
    xs = rng.uniform(-1, 1, (20, 2))
    expected = 57.3 * model.predict_many(xs)
    np.testing.assert_allclose(other.predict_many(1e3 * xs), expected, rtol=1e-8, atol=1e-8)


def test_examples_without_worth_change_nothing() -> None:
    """Against the intention, or without a movement: no step, and no new map far away either."""
    model = ScaledModel.at_home(CONFIG, HOME_ACTION, HOME_OUTCOME)
    right, far = np.array([0.1, 0.0]), np.array([5.0, 5.0])
    model.learn(np.ones(3), far, np.ones(3), -right, right)
    model.learn(np.ones(3), far, np.zeros(3), right, right)
    model.learn(np.ones(3), far, np.ones(3), np.zeros(2), None)
    assert model.model.count == 1
    np.testing.assert_array_equal(model.predict(far), HOME_ACTION)


def test_steps_within_the_resolution_are_not_learned() -> None:
    """The resolutions are in the units of the robot, whatever the scales."""
    config = GoalBabblerConfig(action_scale=0.15, outcome_scale=0.45, action_resolution=1e-3)
    model = ScaledModel.at_home(config, HOME_ACTION, HOME_OUTCOME)
    step = np.array([0.9e-3, 0.0, 0.0])
    model.learn(np.ones(3), HOME_OUTCOME, step, np.array([0.1, 0.0]), None)
    np.testing.assert_allclose(model.predict(HOME_OUTCOME), HOME_ACTION, rtol=1e-15)
    model.learn(np.ones(3), HOME_OUTCOME, 1.2 * step, np.array([0.1, 0.0]), None)
    assert np.abs(model.predict(HOME_OUTCOME) - HOME_ACTION).max() > 0.01


@pytest.mark.parametrize("efficiency", ["plain", "relative"])
@pytest.mark.parametrize("kind", ["local_linear_maps", "recursive_maps"])
def test_restored_continues_bit_for_bit(efficiency: str, kind: str) -> None:
    config = GoalBabblerConfig(efficiency=efficiency, efficiency_limit=2.0, model=kind)
    model, rng = ScaledModel.at_home(config, HOME_ACTION, HOME_OUTCOME), np.random.default_rng(2)
    for _ in range(30):
        model.learn(*example(rng))
    twin = ScaledModel.restore(config, model.state())
    assert twin.model.kind == kind
    for _ in range(30):
        given = example(rng)
        model.learn(*given)
        twin.learn(*given)
    xs = rng.uniform(-1, 1, (20, 2))
    np.testing.assert_array_equal(twin.predict_many(xs), model.predict_many(xs))


def test_refuses_unknown_models() -> None:
    state = ScaledModel.at_home(CONFIG, HOME_ACTION, HOME_OUTCOME).state()
    with pytest.raises(InvalidConfigError, match="local_linear_maps"):
        ScaledModel.restore(CONFIG, type(state)(state.arrays, {**state.settings, "kind": "elm"}))
