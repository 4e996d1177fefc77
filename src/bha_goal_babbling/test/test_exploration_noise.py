"""Exploration noise: spread, memory, smoothness in the target."""

import numpy as np
import pytest

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.exploration_noise import ExplorationNoise


@pytest.mark.parametrize(("spread", "step"), [(0.05, 0.01), (0.03, 0.03), (0.03, 0.3)])
def test_spread_stays(spread: float, step: float) -> None:
    """After any number of steps every entry has the standard deviation it started with."""
    rng = np.random.default_rng(0)
    noise = ExplorationNoise(spread, step, 20_000, 1, rng)
    for _ in range(200):
        noise.advance(rng)
    entries = noise.state().arrays["entries"]
    assert entries.std() == pytest.approx(spread, rel=0.02)
    assert abs(entries.mean()) < 0.02 * spread


def test_one_step_is_remembered_as_the_formula_says() -> None:
    """Entries of successive steps correlate by s / sqrt(s^2 + sd^2)."""
    rng = np.random.default_rng(1)
    noise = ExplorationNoise(0.05, 0.01, 50_000, 1, rng)
    before = noise.state().arrays["entries"].ravel()
    noise.advance(rng)
    after = noise.state().arrays["entries"].ravel()
    assert np.corrcoef(before, after)[0, 1] == pytest.approx(0.05 / np.hypot(0.05, 0.01), abs=2e-3)


def test_is_linear_in_the_target() -> None:
    """E(x) = A x + c: c at 0, and differences that only depend on differences."""
    noise = ExplorationNoise(0.1, 0.1, 4, 3, np.random.default_rng(2))
    x, y = np.array([0.2, -0.1, 0.5]), np.array([-0.3, 0.4, 0.1])
    c = noise.at(np.zeros(3))
    assert noise.at(x).shape == (4,)
    np.testing.assert_allclose(noise.at(x + y) - c, noise.at(x) - c + noise.at(y) - c, atol=1e-15)
    assert np.linalg.norm(noise.at(x) - c) > 0


def test_no_spread_is_no_noise() -> None:
    """Spread 0 stays 0 whatever the step."""
    rng = np.random.default_rng(3)
    noise = ExplorationNoise(0.0, 0.1, 4, 2, rng)
    noise.advance(rng)
    np.testing.assert_array_equal(noise.at(np.ones(2)), np.zeros(4))


def test_no_step_is_constant_noise() -> None:
    """Step 0 leaves the first entries as they are."""
    rng = np.random.default_rng(4)
    noise = ExplorationNoise(0.1, 0.0, 4, 2, rng)
    before = noise.at(np.ones(2))
    noise.advance(rng)
    np.testing.assert_array_equal(noise.at(np.ones(2)), before)


def test_refuses_negative_spread() -> None:
    """Standard deviations are not negative."""
    with pytest.raises(InvalidConfigError, match="must not be negative"):
        ExplorationNoise(-0.1, 0.1, 4, 2, np.random.default_rng(0))


def test_refuses_a_snapshot_of_another_size() -> None:
    """Noise for other numbers of coordinates does not fit."""
    rng = np.random.default_rng(5)
    small, large = ExplorationNoise(0.1, 0.1, 4, 2, rng), ExplorationNoise(0.1, 0.1, 5, 2, rng)
    with pytest.raises(InvalidConfigError, match="shape"):
        small.load(large.state())
