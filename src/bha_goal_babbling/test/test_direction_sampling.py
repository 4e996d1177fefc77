"""Direction sampling: straight on while it goes well, a new direction when thrown back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_goal_babbling.direction_sampling import DirectionTargets
from bha_goal_babbling.errors import InvalidConfigError


@given(st.integers(1, 4), st.floats(1e-3, 1.0), st.integers(0, 2**32))
def test_targets_are_evenly_spaced_on_a_line(size: int, step: float, seed: int) -> None:
    """The first target is one step from the outcome, each next one step farther."""
    targets, rng = DirectionTargets(step, size), np.random.default_rng(seed)
    outcome = rng.standard_normal(size)
    start = targets.begin(rng.standard_normal(size), outcome, rng)
    np.testing.assert_array_equal(start, outcome)
    first = targets.target() - outcome
    assert np.linalg.norm(first) == pytest.approx(step)
    for k in range(2, 6):
        assert not targets.advance(first)
        np.testing.assert_allclose(targets.target(), outcome + k * first, atol=1e-12)


def test_ends_when_the_outcome_moves_against_the_direction() -> None:
    """Across, to a rounding forwards, still counts as following; against does not."""
    targets, rng = DirectionTargets(0.1, 2), np.random.default_rng(0)
    targets.begin(np.zeros(2), np.zeros(2), rng)
    direction = targets.target() / 0.1
    across = np.array([-direction[1], direction[0]]) + 1e-9 * direction
    assert not targets.advance(across)
    assert targets.advance(across - 0.01 * direction)


def test_directions_cover_the_circle() -> None:
    """All directions are equally likely."""
    targets, rng = DirectionTargets(1.0, 2), np.random.default_rng(1)
    seen = []
    for _ in range(8000):
        targets.begin(np.zeros(2), np.zeros(2), rng)
        seen.append(targets.target())
    angles = np.arctan2(*np.array(seen).T)
    counts, _ = np.histogram(angles, bins=8, range=(-np.pi, np.pi))
    np.testing.assert_allclose(counts, 1000, rtol=0.12)


def test_restored_directions_go_on() -> None:
    """A snapshot continues the same line."""
    targets = DirectionTargets(0.1, 3)
    targets.begin(np.zeros(3), np.ones(3), np.random.default_rng(2))
    twin = DirectionTargets.restore(targets.state())
    targets.advance(np.zeros(3))
    twin.advance(np.zeros(3))
    np.testing.assert_array_equal(targets.target(), twin.target())


@pytest.mark.parametrize(("step", "size"), [(0.0, 2), (-1.0, 2), (np.nan, 2), (0.1, 0)])
def test_refuses_impossible_settings(step: float, size: int) -> None:
    """A step has a length, a target coordinates."""
    with pytest.raises(InvalidConfigError, match="step must be above 0"):
        DirectionTargets(step, size)
