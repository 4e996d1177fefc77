"""Goal choice: within the set, never twice running, uniform otherwise."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_choice import LargestErrorChoice, RandomGoalChoice


@given(st.integers(2, 50), st.integers(0, 2**32))
def test_never_the_same_twice_running(count: int, seed: int) -> None:
    """Successive goals differ, and each is one of the set."""
    choice, rng = RandomGoalChoice(count), np.random.default_rng(seed)
    drawn = [choice.choose(rng) for _ in range(40)]
    assert all(0 <= goal < count for goal in drawn)
    assert all(a != b for a, b in itertools.pairwise(drawn))


def test_two_goals_take_turns() -> None:
    """With two goals there is nothing left to chance but the first."""
    choice, rng = RandomGoalChoice(2, last=0), np.random.default_rng(0)
    assert [choice.choose(rng) for _ in range(4)] == [1, 0, 1, 0]


def test_all_others_are_equally_likely() -> None:
    """After goal 2 of 5 each other one comes in a quarter of the cases."""
    rng = np.random.default_rng(1)
    counts = np.bincount(
        [RandomGoalChoice(5, last=2).choose(rng) for _ in range(8000)], minlength=5
    )
    assert counts[2] == 0
    np.testing.assert_allclose(counts[[0, 1, 3, 4]], 2000, rtol=0.1)


@pytest.mark.parametrize(("count", "last"), [(1, -1), (0, -1), (3, 3), (3, -2)])
def test_refuses_sets_without_a_choice(count: int, last: int) -> None:
    """One goal alone would have to come twice running."""
    with pytest.raises(InvalidConfigError, match="must"):
        RandomGoalChoice(count, last)


def test_one_candidate_is_a_random_choice() -> None:
    """Errors do not matter then, and the random numbers are used alike."""
    plain, rng = RandomGoalChoice(6), np.random.default_rng(2)
    choice, twin = LargestErrorChoice(1), np.random.default_rng(2)
    errors = np.arange(6.0)
    for _ in range(50):
        assert choice.choose(errors, twin) == plain.choose(rng)


def test_the_largest_error_of_three_comes() -> None:
    """Goal of rank r from below comes in (r^3 - (r - 1)^3) / G^3 of the cases, if not the last."""
    rng, errors = np.random.default_rng(3), np.array([0.3, 9.0, 0.1, 0.2])
    drawn = [LargestErrorChoice(3, last=1).choose(errors, rng) for _ in range(8000)]
    counts = np.bincount(drawn, minlength=4)
    assert counts[1] == 0
    np.testing.assert_allclose(counts[[2, 3, 0]] / 8000, np.array([1, 7, 19]) / 27, atol=0.02)


def test_largest_error_never_comes_twice_running() -> None:
    choice, rng, errors = LargestErrorChoice(5), np.random.default_rng(4), np.array([9.0, 1, 1])
    drawn = [choice.choose(errors, rng) for _ in range(100)]
    assert all(a != b for a, b in itertools.pairwise(drawn))


def test_refuses_to_draw_nothing() -> None:
    with pytest.raises(InvalidConfigError, match="at least 1"):
        LargestErrorChoice(0)
