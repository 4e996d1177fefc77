"""Local linear maps: insertion, slope, gradient step, far queries, snapshots."""

import itertools

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.local_linear_map import LocalLinearMaps

D = 0.1


def trained(n: int = 2, m: int = 5, seed: int = 0, samples: int = 300) -> LocalLinearMaps:
    """Return maps that have seen a smooth function, so that values and slopes are not zero."""
    rng = np.random.default_rng(seed)
    maps = LocalLinearMaps(D, 0.5, np.zeros(n), np.zeros(m))
    mix = rng.standard_normal((m, n))
    for _ in range(samples):
        x = rng.uniform(-0.4, 0.4, n)
        maps.learn(x, np.sin(3.0 * mix @ x), 1.0)
    return maps


def numerical_slope(maps: LocalLinearMaps, x: FloatArray, step: float = 1e-6) -> FloatArray:
    """Return dg/dx by central differences, shape (m, n)."""
    columns = [
        (maps.predict(x + step * axis) - maps.predict(x - step * axis)) / (2.0 * step)
        for axis in np.eye(x.size)
    ]
    return np.stack(columns, axis=1)


def test_starts_as_a_constant() -> None:
    """One map with the home action: the same answer everywhere."""
    maps = LocalLinearMaps(D, 1.0, np.array([0.7, 0.0]), np.array([0.1, 0.2, 0.3]))
    for x in ([0.7, 0.0], [0.0, 0.5], [-40.0, 3.0]):
        np.testing.assert_array_equal(maps.predict(np.array(x)), [0.1, 0.2, 0.3])
    assert maps.count == 1


@pytest.mark.parametrize("n", [1, 2, 3])
def test_slope_is_the_derivative(n: int) -> None:
    """The slope contains the change of the responsibilities as well."""
    maps = trained(n)
    assert maps.count > 3
    for x in np.random.default_rng(1).uniform(-0.5, 0.5, (20, n)):
        np.testing.assert_allclose(maps.slope(x), numerical_slope(maps, x), rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_insertion_leaves_value_and_slope(n: int) -> None:
    """At the new centre g is what it was to 1e-15, and the new map's slope is that of old g."""
    for seed in range(10):
        maps = trained(n, seed=seed)
        x = np.random.default_rng(seed).uniform(-0.6, 0.6, n)
        value, slope = maps.predict(x), numerical_slope(maps, x)
        maps.insert(x)
        scale = max(1.0, float(np.abs(maps.values).max()))
        np.testing.assert_allclose(maps.predict(x), value, rtol=0, atol=2e-15 * scale)
        np.testing.assert_array_equal(maps.values[-1], value)
        np.testing.assert_allclose(maps.slopes[-1] / D, slope, rtol=1e-5, atol=1e-6)
        np.testing.assert_allclose(numerical_slope(maps, x), slope, rtol=1e-5, atol=1e-6)


def test_inserts_only_beyond_the_distance() -> None:
    """A new map where all others are farther than d, none within."""
    maps = LocalLinearMaps(D, 0.5, np.zeros(2), np.zeros(3))
    maps.learn(np.array([0.999 * D, 0.0]), np.ones(3), 1.0)
    assert maps.count == 1
    maps.learn(np.array([0.0, 1.001 * D]), np.ones(3), 1.0)
    assert maps.count == 2
    np.testing.assert_array_equal(maps.centers[1], [0.0, 1.001 * D])


def test_every_pair_of_centres_is_apart() -> None:
    """Centres never come closer than d, however many samples there are (the buffers grow)."""
    maps = trained(2, samples=2000)
    assert maps.count > 16
    gaps = np.linalg.norm(maps.centers[:, np.newaxis] - maps.centers, axis=2)
    assert gaps[~np.eye(maps.count, dtype=bool)].min() > D


def test_one_map_takes_the_step_of_the_formula() -> None:
    """With a single map h is 1: v and M move by eta w (q - g) and eta w (q - g) z'."""
    maps = LocalLinearMaps(D, 0.5, np.zeros(2), np.zeros(3))
    x, q = np.array([0.05, -0.02]), np.array([1.0, -2.0, 3.0])
    maps.learn(x, q, 0.4)
    np.testing.assert_allclose(maps.values[0], 0.5 * 0.4 * q)
    np.testing.assert_allclose(maps.slopes[0], 0.5 * 0.4 * np.outer(q, x / D))


def test_step_follows_the_gradient() -> None:
    """The step is minus the gradient of w |q - g(x)|^2 / 2 by all values and slopes."""
    maps = trained(2, 3, samples=50)
    x, q, weight, rate = np.array([0.11, -0.07]), np.array([0.3, 0.1, -0.4]), 0.7, 0.5

    def loss(parameters: FloatArray) -> float:
        state = maps.state()
        changed = LocalLinearMaps.restore(
            type(state)({**state.arrays, "parameters": parameters}, state.settings)
        )
        return 0.5 * weight * float(np.sum((q - changed.predict(x)) ** 2))

    before = maps.state().arrays["parameters"]
    gradient = np.zeros_like(before)
    for index in np.ndindex(before.shape):
        shift = np.zeros_like(before)
        shift[index] = 1e-5
        gradient[index] = (loss(before + shift) - loss(before - shift)) / 2e-5
    maps.learn(x, q, weight)
    step = maps.state().arrays["parameters"] - before
    np.testing.assert_allclose(step, -rate * gradient, rtol=1e-6, atol=1e-9)


def test_step_reduces_the_error() -> None:
    """A small step brings g(x) closer to q in every coordinate."""
    maps = trained()
    for x in np.random.default_rng(2).uniform(-0.4, 0.4, (30, 2)):
        q = np.full(5, 0.5)
        before = np.abs(q - maps.predict(x))
        maps.learn(x, q, 0.3)
        assert (np.abs(q - maps.predict(x)) < before).all()


def test_many_equals_one_by_one() -> None:
    """The vectorised answer is the single one, also beyond one chunk."""
    maps = trained(3)
    xs = np.random.default_rng(3).uniform(-1.0, 1.0, (2500, 3))
    singles = np.array([maps.predict(x) for x in xs])
    np.testing.assert_allclose(maps.predict_many(xs), singles, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("seed", range(3))
def test_linear_problem_ends_at_the_least_squares_inverse(seed: int) -> None:
    """With isotropic noise, x = F q and no weights, g ends at the pseudo-inverse of F within 1 %.

    The noise runs through +- every axis, so its covariance is exact, and so is the balance.
    """
    rng = np.random.default_rng(seed)
    forward = np.linalg.qr(rng.standard_normal((6, 2)))[0].T * [[1.0], [0.6]]
    goals = np.array(list(itertools.product((-1.0, 0.0, 1.0), repeat=2)))
    pairs = list(itertools.product(goals, np.vstack([np.eye(6), -np.eye(6)])))
    maps = LocalLinearMaps(2.5, 0.02, np.zeros(2), np.zeros(6))
    for _ in range(50):
        for index in rng.permutation(len(pairs)):
            goal, noise = pairs[index]
            action = maps.predict(goal) + noise
            maps.learn(forward @ action, action, 1.0)
    expected = goals @ np.linalg.pinv(forward).T
    miss = np.linalg.norm(maps.predict_many(goals) - expected)
    assert miss < 0.01 * np.linalg.norm(expected)


@pytest.mark.parametrize("far", [27.0, 100.0, 1e6])
def test_far_queries_stay_finite(far: float) -> None:
    """Beyond 27 d all exponentials are zero in double precision; g is not 0 / 0 there."""
    maps = trained()
    x = np.array([far * D, far * D])
    assert np.isfinite(maps.predict(x)).all()
    assert np.isfinite(maps.predict_many(x[np.newaxis])).all()
    maps.learn(x, np.ones(5), 1.0)
    assert np.isfinite(maps.predict(x)).all()


def test_restored_maps_continue_bit_for_bit() -> None:
    """A snapshot is independent of what comes after and gives the same numbers."""
    maps = trained()
    twin = LocalLinearMaps.restore(maps.state())
    rng = np.random.default_rng(4)
    for _ in range(200):
        x, q = rng.uniform(-0.8, 0.8, 2), rng.standard_normal(5)
        maps.learn(x, q, 0.5)
        twin.learn(x, q, 0.5)
    assert maps.count == twin.count
    np.testing.assert_array_equal(
        maps.state().arrays["parameters"], twin.state().arrays["parameters"]
    )


@pytest.mark.parametrize(("distance", "rate"), [(0.0, 1.0), (-1.0, 1.0), (0.1, 0.0), (np.nan, 1.0)])
def test_refuses_impossible_settings(distance: float, rate: float) -> None:
    """Distance and rate must be above zero."""
    with pytest.raises(InvalidConfigError, match="above 0"):
        LocalLinearMaps(distance, rate, np.zeros(2), np.zeros(2))


def test_refuses_a_snapshot_that_does_not_fit_together() -> None:
    """Centres and parameters of different numbers of maps are no model."""
    state = trained().state()
    broken = {**state.arrays, "centers": state.arrays["centers"][:-1]}
    with pytest.raises(InvalidConfigError, match="parameters have shape"):
        LocalLinearMaps.restore(type(state)(broken, state.settings))
