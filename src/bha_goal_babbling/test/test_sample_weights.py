"""Weights of examples: equations 4 and 5, their boundaries, limits, units."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.sample_weights import SampleWeights, direction_weight, movement_efficiency

RIGHT, UP, ZERO = np.array([0.1, 0.0]), np.array([0.0, 0.1]), np.zeros(2)
numbers = st.floats(-1e3, 1e3, allow_subnormal=False)
pairs = st.tuples(numbers, numbers).map(np.array)


def test_direction_known_values() -> None:
    """1 along, 1/2 across, 0 against, by the angle in between."""
    assert direction_weight(RIGHT, 3.0 * RIGHT) == 1.0
    assert direction_weight(RIGHT, UP) == pytest.approx(0.5)
    assert direction_weight(RIGHT, -RIGHT) == 0.0
    assert direction_weight(RIGHT, RIGHT + UP) == pytest.approx(0.5 * (1 + np.sqrt(0.5)))


def test_direction_without_a_step_is_half() -> None:
    """A target or an outcome that stands still has no direction."""
    assert direction_weight(ZERO, RIGHT) == 0.5
    assert direction_weight(RIGHT, ZERO) == 0.5
    assert direction_weight(ZERO, ZERO) == 0.5


def test_direction_within_the_resolution_is_half() -> None:
    """Steps of the outcome that are sensor noise have no direction either."""
    assert direction_weight(RIGHT, 0.01 * RIGHT, resolution=0.001) == 0.5
    assert direction_weight(RIGHT, 0.011 * RIGHT, resolution=0.001) == 1.0


@given(pairs, pairs, st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_direction_is_a_weight_and_knows_no_length(
    target: np.ndarray, outcome: np.ndarray, a: float, b: float
) -> None:
    """It lies in [0, 1] and depends on directions alone."""
    weight = direction_weight(target, outcome)
    assert 0.0 <= weight <= 1.0
    if min(np.abs(target).max(), np.abs(outcome).max()) > 1e-100:
        assert direction_weight(a * target, b * outcome) == pytest.approx(weight, abs=1e-9)


def test_efficiency_known_values() -> None:
    """Outcome moved per action moved; nothing moved weighs nothing."""
    assert movement_efficiency(np.array([3.0, 4.0, 0.0]), np.array([1.0, 0.0])) == 0.2
    assert movement_efficiency(np.ones(3), ZERO) == 0.0
    assert movement_efficiency(np.zeros(3), RIGHT) == 0.0
    assert movement_efficiency(np.array([1e-3, 0, 0]), RIGHT, resolution=1e-3) == 0.0


def test_goal_step_multiplies_both() -> None:
    """w = w_dir w_eff, and w = w_eff alone on the way home."""
    weights = SampleWeights()
    q = np.array([0.2, 0.0, 0.0])
    assert weights.of_goal_step(UP, q, RIGHT) == pytest.approx(0.25)
    assert weights.of_goal_step(-RIGHT, q, RIGHT) == 0.0
    assert weights.of_home_step(q, RIGHT) == pytest.approx(0.5)


def test_limit_bounds_the_efficiency() -> None:
    """Efficiency beyond the limit counts as the limit, below it as it is."""
    weights = SampleWeights(limit=1.0)
    assert weights.of_goal_step(UP, 0.01 * RIGHT, RIGHT) == pytest.approx(0.5)
    assert weights.of_home_step(2.0 * RIGHT, RIGHT) == pytest.approx(0.5)


@given(st.floats(1e-4, 1e4))
def test_relative_weights_forget_the_unit(unit: float) -> None:
    """Actions in another unit give the same relative weights once the first have been seen."""
    rng = np.random.default_rng(0)
    plain, scaled = SampleWeights(relative=True), SampleWeights(relative=True)
    for _ in range(1500):
        action, outcome = rng.standard_normal(3), rng.standard_normal(2)
        expected = plain.of_home_step(action, outcome)
        got = scaled.of_home_step(unit * action, outcome)
    assert got == pytest.approx(expected, rel=0.02)


def test_relative_weights_have_mean_one() -> None:
    """Divided by their running mean, efficiencies are about 1 on average."""
    rng = np.random.default_rng(1)
    weights = SampleWeights(relative=True)
    seen = [
        weights.of_home_step(7.0 * rng.uniform(1, 2, 3), rng.uniform(1, 2, 2)) for _ in range(2000)
    ]
    assert np.mean(seen[1000:]) == pytest.approx(1.0, abs=0.05)


def test_standing_still_does_not_change_the_mean() -> None:
    """Samples that are not learned say nothing about the usual efficiency."""
    weights = SampleWeights(relative=True)
    weights.of_home_step(RIGHT, RIGHT)
    before = weights.state().settings
    assert weights.of_home_step(ZERO, RIGHT) == 0.0
    assert weights.state().settings == before


def test_refuses_a_limit_that_lets_nothing_pass() -> None:
    """The limit is above zero."""
    with pytest.raises(InvalidConfigError, match="above 0"):
        SampleWeights(limit=0.0)


def test_weights_can_be_left_out() -> None:
    """What is left out is 1, except where nothing was moved."""
    undirected = SampleWeights(use_direction=False)
    assert undirected.of_goal_step(RIGHT, UP, -2.0 * RIGHT) == pytest.approx(2.0)
    inefficient = SampleWeights(use_efficiency=False)
    assert inefficient.of_goal_step(RIGHT, UP, 2.0 * UP) == pytest.approx(0.5)
    assert inefficient.of_home_step(UP, ZERO) == 1.0
    assert inefficient.of_home_step(ZERO, UP) == 0.0
