"""Recursive maps: least squares where the answer is known, insertion, the compiled twin."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.compiled_recursive_maps import CompiledRecursiveMaps
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.recursive_maps import RecursiveMaps, RecursiveMapsConfig

KINDS = [RecursiveMaps, CompiledRecursiveMaps]
PLAIN = RecursiveMapsConfig(
    distance=10.0, final_distance=10.0, covariance=4.0, process_noise=0.0, covariance_limit=100.0
)
"""One map for all, and no process noise: weighted recursive least squares to the letter."""


def trained(
    kind: type[RecursiveMaps], n: int, m: int, samples: int = 300, seed: int = 0
) -> RecursiveMaps:
    """Return maps that have learned a bent function, across the change to blended learning."""
    rng = np.random.default_rng(seed)
    config = RecursiveMapsConfig(distance=0.5, final_distance=0.3, blend_samples=samples // 2)
    maps = kind(config, np.zeros(n), rng.standard_normal(m))
    mixing = rng.standard_normal((n, m))
    for _ in range(samples):
        x = rng.uniform(-1, 1, n)
        maps.learn(x, np.sin(x @ mixing), rng.exponential())
    return maps


@pytest.mark.parametrize("kind", KINDS)
def test_one_map_is_batch_weighted_least_squares(kind: type[RecursiveMaps]) -> None:
    """With the first covariance as a prior: (P0^-1 + U'WU) theta = P0^-1 theta0 + U'W Q."""
    rng = np.random.default_rng(1)
    center, first = np.array([0.3, -0.2]), np.array([1.0, 2.0, 3.0])
    maps = kind(PLAIN, center, first)
    x, q = rng.uniform(-1, 1, (40, 2)), rng.standard_normal((40, 3))
    w = rng.uniform(0.01, 3.0, 40)
    for row in range(40):
        maps.learn(x[row], q[row], w[row])
    u = np.column_stack([np.ones(40), (x - center) / 10.0])
    information = np.eye(3) / 4.0 + u.T @ (w[:, np.newaxis] * u)
    prior = np.vstack([first, np.zeros((2, 3))]) / 4.0
    expected = np.linalg.solve(information, prior + u.T @ (w[:, np.newaxis] * q))
    assert maps.count == 1
    np.testing.assert_allclose(maps.parameters[0], expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(maps.covariances[0], np.linalg.inv(information), rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("blend_samples", [1000.0, 1e9])
def test_a_linear_function_is_found(kind: type[RecursiveMaps], blend_samples: float) -> None:
    """Many maps agree on it, whichever residual they learn from."""
    rng = np.random.default_rng(2)
    inverse = rng.standard_normal((4, 2))
    config = RecursiveMapsConfig(distance=0.4, final_distance=0.2, blend_samples=blend_samples)
    maps = kind(config, np.zeros(2), np.zeros(4))
    for x in rng.uniform(-1, 1, (3000, 2)):
        maps.learn(x, inverse @ x, 1.0)
    x = rng.uniform(-0.9, 0.9, (50, 2))
    assert maps.count > 20
    np.testing.assert_allclose(maps.predict_many(x), x @ inverse.T, atol=1e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_the_blend_is_learned_closer_than_by_single_maps(kind: type[RecursiveMaps]) -> None:
    """On a bent function maps fitted one by one leave a bias where they are blended."""

    def error(blend_samples: float) -> float:
        rng = np.random.default_rng(3)
        config = RecursiveMapsConfig(distance=0.5, final_distance=0.5, blend_samples=blend_samples)
        maps = kind(config, np.zeros(1), np.zeros(1))
        for x in rng.uniform(-1, 1, (2000, 1)):
            maps.learn(x, np.sin(3 * x), 1.0)
        x = np.linspace(-0.9, 0.9, 50)[:, np.newaxis]
        return float(np.abs(maps.predict_many(x) - np.sin(3 * x)).mean())

    assert error(500.0) < 0.5 * error(1e9)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("n", "m"), [(1, 1), (2, 5), (3, 9)])
def test_insertion_leaves_value_and_slope(kind: type[RecursiveMaps], n: int, m: int) -> None:
    """Maps of different reach around, the new one in between or beyond them."""
    rng = np.random.default_rng(4)
    for scale in (0.5, 2.0):
        maps = trained(kind, n, m)
        x = scale * rng.uniform(-1, 1, n)
        value, slope = maps.predict(x), maps.slope(x)
        maps.insert(x)
        np.testing.assert_array_equal(maps.centers[-1], x)
        np.testing.assert_allclose(maps.predict(x), value, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(maps.slope(x), slope, rtol=1e-10, atol=1e-10)


def test_slope_is_the_derivative() -> None:
    """The numerical one, the change of the responsibilities included."""
    maps, x = trained(RecursiveMaps, 3, 4), np.array([0.2, -0.5, 0.4])
    steps = 1e-5 * np.eye(3)
    numerical = (maps.predict_many(x + steps) - maps.predict_many(x - steps)).T / 2e-5
    np.testing.assert_allclose(maps.slope(x), numerical, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_new_maps_appear_beyond_a_reach_that_shrinks(kind: type[RecursiveMaps]) -> None:
    """d_0 / sqrt(1 + t / t_0), and not below the final one."""
    config = RecursiveMapsConfig(distance=0.1, final_distance=0.05, shrink_samples=500)
    assert config.distance_at(0) == 0.1
    assert config.distance_at(500) == pytest.approx(0.1 / np.sqrt(2))
    assert config.distance_at(10**6) == 0.05
    maps, q = kind(config, np.zeros(2), np.zeros(3)), np.ones(3)
    maps.learn(np.array([0.0, 0.09]), q, 1.0)
    assert maps.count == 1
    maps.learn(np.array([0.0, 0.101]), q, 1.0)
    assert maps.count == 2
    for _ in range(1500):
        maps.learn(np.zeros(2), q, 1.0)
    maps.learn(np.array([0.06, 0.0]), q, 1.0)
    np.testing.assert_allclose(maps.distances, [0.1, config.distance_at(1), 0.05])


@given(
    st.integers(1, 4), st.integers(1, 12), st.booleans(), st.integers(0, 2**32), st.floats(-3, 1)
)
@settings(max_examples=60, deadline=None)
def test_compiled_is_the_reference(
    n: int, m: int, blended: bool, seed: int, log_weight: float
) -> None:
    """Prediction, insertion and correction from the same random state, to 1e-12."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 30))
    mixing = rng.standard_normal((count, 1 + n, 1 + n))
    state = RecursiveMaps(
        RecursiveMapsConfig(blend_samples=0.0 if blended else 1e9), np.zeros(n), np.zeros(m)
    ).state()
    arrays = {
        "centers": rng.uniform(-0.3, 0.3, (count, n)),
        "distances": rng.uniform(0.05, 0.1, count),
        "parameters": rng.standard_normal((count, 1 + n, m)),
        "covariances": mixing @ mixing.transpose(0, 2, 1) + 0.1 * np.eye(1 + n),
    }
    reference = RecursiveMaps.restore(type(state)(arrays, state.settings))
    compiled = CompiledRecursiveMaps.restore(type(state)(arrays, state.settings))
    x, q = rng.uniform(-0.5, 0.5, (10, n)), rng.standard_normal(m)
    for maps in (reference, compiled):
        maps.learn(x[0], q, 10.0**log_weight)
    assert compiled.count == reference.count
    tolerance = {"rtol": 1e-12, "atol": 1e-12 * np.abs(reference.parameters).max()}
    for name in ("centers", "distances", "parameters", "covariances"):
        expected = getattr(reference, name)
        np.testing.assert_allclose(getattr(compiled, name), expected, **tolerance, err_msg=name)
    np.testing.assert_allclose(compiled.predict_many(x), reference.predict_many(x), **tolerance)
    np.testing.assert_array_equal(compiled.predict(x[3]), compiled.predict_many(x)[3])


@pytest.mark.parametrize("kind", KINDS)
def test_far_from_all_maps_nothing_overflows(kind: type[RecursiveMaps]) -> None:
    """The nearest map answers where every plain exponential would be 0."""
    maps = trained(kind, 2, 3)
    far = np.array([40.0, -30.0])
    assert np.isfinite(maps.predict(far)).all()
    assert np.isfinite(maps.slope(far)).all()


@pytest.mark.parametrize("kind", KINDS)
def test_covariances_stay_positive_and_bounded(kind: type[RecursiveMaps]) -> None:
    """Also where only one spot is visited, for long: the directions never seen do not wind up."""
    config = RecursiveMapsConfig(covariance_limit=10.0, process_noise=0.15)
    maps = kind(config, np.zeros(2), np.zeros(3))
    for _ in range(1500):
        maps.learn(np.array([0.01, 0.0]), np.ones(3), 3.0)
    eigenvalues = np.linalg.eigvalsh(maps.covariances[0])
    assert 0.0 < eigenvalues.min() <= eigenvalues.max() <= 10.0 * (1 + 1e-12)
    np.testing.assert_array_equal(maps.covariances[0], maps.covariances[0].T)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("samples", [20, 400])
def test_restored_continues_bit_for_bit(kind: type[RecursiveMaps], samples: int) -> None:
    maps, rng = trained(kind, 2, 5, samples), np.random.default_rng(5)
    twin = kind.restore(maps.state())
    assert type(twin) is kind
    for _ in range(200):
        x, q, w = rng.uniform(-1.5, 1.5, 2), rng.standard_normal(5), rng.exponential()
        maps.learn(x, q, w)
        twin.learn(x, q, w)
    assert twin.examples == maps.examples == samples + 200
    for name in ("centers", "distances", "parameters", "covariances"):
        np.testing.assert_array_equal(getattr(twin, name), getattr(maps, name))


def test_a_snapshot_is_a_copy() -> None:
    maps = trained(CompiledRecursiveMaps, 2, 3)
    state = maps.state()
    before: dict[str, FloatArray] = {name: array.copy() for name, array in state.arrays.items()}
    for _ in range(50):
        maps.learn(np.zeros(2), np.ones(3), 1.0)
    for name, array in before.items():
        np.testing.assert_array_equal(state.arrays[name], array)


@pytest.mark.parametrize("name", ["centers", "distances", "parameters", "covariances"])
def test_refuses_snapshots_that_do_not_fit_together(name: str) -> None:
    state = trained(CompiledRecursiveMaps, 2, 3).state()
    arrays = {**state.arrays, name: state.arrays[name][:-1]}
    with pytest.raises(InvalidConfigError, match="shape"):
        CompiledRecursiveMaps.restore(type(state)(arrays, state.settings))


@pytest.mark.parametrize("field", [field.name for field in dataclasses.fields(RecursiveMapsConfig)])
@pytest.mark.parametrize("value", [-1.0, float("nan"), float("inf")])
def test_refuses_settings_out_of_range(field: str, value: float) -> None:
    with pytest.raises(InvalidConfigError, match=field):
        RecursiveMapsConfig(**{field: value})
