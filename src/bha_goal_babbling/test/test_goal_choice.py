"""Goal choice: within the set, never twice running, uniform otherwise."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_choice import RandomGoalChoice


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
