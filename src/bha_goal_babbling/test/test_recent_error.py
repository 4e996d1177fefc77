"""The running mean of distances."""

import math

import numpy as np
import pytest

from bha_goal_babbling.recent_error import RecentError


def test_nothing_at_first() -> None:
    assert math.isnan(RecentError(5).value)


def test_plain_mean_at_first() -> None:
    recent = RecentError(5)
    for distance in (1.0, 2.0, 6.0):
        recent.add(distance)
    assert recent.value == pytest.approx(3.0)


def test_forgets_what_is_long_ago() -> None:
    recent = RecentError(5)
    recent.add(1000.0)
    for _ in range(100):
        recent.add(2.0)
    assert recent.value == pytest.approx(2.0, abs=1e-6)


def test_window_of_one_is_the_last() -> None:
    recent = RecentError(1)
    for distance in (3.0, 1.0, 2.0):
        recent.add(distance)
    assert recent.value == 2.0


@pytest.mark.parametrize("count", [0, 1, 3, 20])
def test_restored_continues(count: int) -> None:
    recent, twin = RecentError(5), RecentError(5)
    rng = np.random.default_rng(0)
    for _ in range(count):
        recent.add(rng.random())
    twin.load(recent.state())
    np.testing.assert_equal(twin.value, recent.value)
    recent.add(0.5)
    twin.add(0.5)
    assert twin.value == recent.value
