"""Straight lines: ends and spacing; a walk along them, and its snapshots."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.straight_walk import StraightWalk, straight_line

points = st.lists(st.floats(-10, 10), min_size=3, max_size=3).map(np.array)


@given(points, points, st.integers(1, 40))
def test_line_leaves_out_the_start_and_meets_the_end(
    start: np.ndarray, end: np.ndarray, steps: int
) -> None:
    """L points, evenly spaced, the last exactly the end."""
    line = straight_line(start, end, steps)
    assert line.shape == (steps, 3)
    np.testing.assert_array_equal(line[-1], end)
    gaps = np.diff(np.vstack([start, line]), axis=0)
    np.testing.assert_allclose(gaps, np.tile((end - start) / steps, (steps, 1)), atol=1e-12)


def test_line_needs_a_step() -> None:
    """A path without steps is none."""
    with pytest.raises(InvalidConfigError, match="at least 1 step"):
        straight_line(np.zeros(2), np.ones(2), 0)


def test_a_walk_takes_the_points_of_the_line() -> None:
    """One after the other; the goal is the last, and tells that it was."""
    walk = StraightWalk(3, 4)
    walk.begin(np.zeros(3), np.ones(3))
    for number, point in enumerate(straight_line(np.zeros(3), np.ones(3), 4)):
        np.testing.assert_array_equal(walk.target, point)
        assert walk.advance() == (number == 3)
    np.testing.assert_array_equal(walk.goal, np.ones(3))


def test_a_walk_may_stay_at_its_goal() -> None:
    walk = StraightWalk(3, 4)
    walk.begin(np.zeros(3), np.ones(3), stay=2)
    line = straight_line(np.zeros(3), np.ones(3), 4)
    for number, point in enumerate([*line, line[-1], line[-1]]):
        np.testing.assert_array_equal(walk.target, point)
        assert walk.stays == (number > 3)
        assert walk.advance() == (number == 5)


def test_a_walk_needs_a_step() -> None:
    with pytest.raises(InvalidConfigError, match="at least 1 step"):
        StraightWalk(3, 0)


@given(points, points, st.integers(0, 4))
def test_a_restored_walk_goes_on(start: np.ndarray, goal: np.ndarray, taken: int) -> None:
    """Beside what its owner has saved; before the first movement as well."""
    walk = StraightWalk(3, 5)
    if taken:
        walk.begin(start, goal, stay=2)
        for _ in range(taken):
            walk.advance()
    state = walk.saved_in({"mine": start}, {"also": 1})
    np.testing.assert_array_equal(state.arrays["mine"], start)
    assert state.settings["also"] == 1
    twin = StraightWalk.restored_from(state, 3)
    if taken:
        np.testing.assert_array_equal(twin.target, walk.target)
        assert twin.advance() == walk.advance()
    twin.begin(goal, start)
    walk.begin(goal, start)
    np.testing.assert_array_equal(twin.target, walk.target)
