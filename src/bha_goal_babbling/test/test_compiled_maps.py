"""Machine code of the local linear maps against the reference, step by step."""

import math

import numpy as np
import pytest

from bha_goal_babbling import compiled_kernels as kernels
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.compiled_maps import CUTOFF, CompiledMaps
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.local_linear_map import LocalLinearMaps

D = 0.1


def trained(n: int, m: int, samples: int = 300) -> LocalLinearMaps:
    """Return maps that have seen a smooth function."""
    rng = np.random.default_rng(0)
    maps = LocalLinearMaps(D, 0.5, np.zeros(n), np.zeros(m))
    mix = rng.standard_normal((m, n))
    for _ in range(samples):
        x = rng.uniform(-0.4, 0.4, n)
        maps.learn(x, np.sin(3.0 * mix @ x), 1.0)
    return maps


def close(ours: FloatArray, reference: FloatArray) -> None:
    """Compare to 1e-12 of the largest entry."""
    np.testing.assert_allclose(ours, reference, rtol=0.0, atol=1e-12 * np.abs(reference).max())


def near_sum(maps: LocalLinearMaps, x: FloatArray) -> FloatArray:
    """Return g at x, shape (m,), over the maps that are not cut off, by the formula."""
    z = (x - maps.centers) / maps.state().settings["distance"]
    squared = (z**2).sum(axis=1)
    h = np.exp(squared.min() - squared)
    h[h < CUTOFF] = 0.0
    h /= h.sum()
    g: FloatArray = h @ (maps.values + np.einsum("kmn,kn->km", maps.slopes, z))
    return g


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("m", [1, 5, 20])
def test_every_step_is_the_reference_step(n: int, m: int) -> None:
    """Without a cut-off prediction, slope, insertion and lesson agree to 1e-12."""
    reference = trained(n, m)
    maps = CompiledMaps.restore(reference.state(), cutoff=0.0)
    rng = np.random.default_rng(1)
    for x in rng.uniform(-0.6, 0.6, (20, n)):
        close(maps.predict(x), reference.predict(x))
        close(maps.slope(x), reference.slope(x))
        action, weight = rng.standard_normal(m), rng.uniform()
        reference.learn(x, action, weight)
        maps.learn(x, action, weight)
        assert maps.count == reference.count
    far = rng.uniform(-30.0, 30.0, (10, n))
    close(maps.predict_many(far), reference.predict_many(far))
    maps.insert(far[0])
    reference.insert(far[0])
    for name, array in reference.state().arrays.items():
        close(maps.state().arrays[name], array)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_the_cutoff_drops_the_small_and_only_those(n: int) -> None:
    """What the grid finds is the plain sum over the maps that count, near and far away."""
    reference = trained(n, 5, 600)
    maps = CompiledMaps.restore(reference.state(), CUTOFF)
    for x in np.random.default_rng(2).uniform(-1.0, 1.0, (200, n)):
        close(maps.predict(x), near_sum(reference, x))


def test_the_cutoff_changes_little() -> None:
    """Within the maps g moves by less than 1 % of the range of the actions."""
    reference = trained(2, 5, 2000)
    maps = CompiledMaps.restore(reference.state())
    points = np.random.default_rng(3).uniform(-0.4, 0.4, (500, 2))
    exact = reference.predict_many(points)
    difference = np.abs(maps.predict_many(points) - exact).max()
    assert 0.0 < difference < 0.01 * np.ptp(exact)


def test_many_maps_are_found_again() -> None:
    """After thousands of insertions every map is in the lists of its neighbourhood."""
    maps = CompiledMaps(0.01, 0.1, np.zeros(2), np.zeros(1))
    points = np.random.default_rng(4).uniform(-0.5, 0.5, (20_000, 2))
    for x in points:
        maps.learn(x, np.array([x[0]]), 1.0)
    assert maps.count > 4000
    twin = LocalLinearMaps.restore(maps.state())
    for x in points[:50]:
        close(maps.predict(x), near_sum(twin, x))


def test_exponentials_and_normals() -> None:
    """The exponential is that of math, the normals are bit for bit those of numpy."""
    exponents = -np.linspace(0.0, 8.0, 10_001)
    values = exponents.copy()
    kernels.exponentials(values, len(values))
    np.testing.assert_allclose(values, np.exp(exponents), rtol=1e-14)
    ours, reference = np.random.default_rng(5), np.random.default_rng(5)
    noise = np.zeros((1000, 1000))
    kernels.walk(ours, 1.0, 1.0, noise)
    drawn = reference.standard_normal((1000, 1000))
    assert np.abs(drawn).max() > 3.7  # The tail, which is another branch, is among them.
    np.testing.assert_array_equal(noise, drawn)
    assert ours.random() == reference.random()


@pytest.mark.parametrize(
    ("distance", "rate", "cutoff"), [(0.0, 1.0, 0.1), (1.0, 0.0, 0.1), (1.0, 1.0, 1.0)]
)
def test_refuses_what_makes_no_sense(distance: float, rate: float, cutoff: float) -> None:
    with pytest.raises(InvalidConfigError, match="cutoff"):
        CompiledMaps(distance, rate, np.zeros(2), np.zeros(3), cutoff)


def test_a_cutoff_of_zero_keeps_all() -> None:
    """The limit of the exponent is infinite, and no grid is searched."""
    maps = CompiledMaps(D, 1.0, np.zeros(2), np.zeros(3), cutoff=0.0)
    assert (maps.arrays.drop, maps.arrays.radius) == (math.inf, 0)
