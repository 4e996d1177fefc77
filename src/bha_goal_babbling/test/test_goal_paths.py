"""Straight paths: how they link up, order of goals, snapshots."""

import numpy as np
import pytest

from bha_goal_babbling.errors import InvalidArrayError, InvalidConfigError
from bha_goal_babbling.goal_paths import GoalPaths

GOALS = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])


def test_movements_link_up() -> None:
    """Each movement starts at the last target, ends at a goal, and takes L steps."""
    paths, rng = GoalPaths(GOALS, 5), np.random.default_rng(0)
    last = np.array([0.3, 0.3])
    for _ in range(20):
        start = paths.begin(last, np.full(2, 9.0), rng)
        np.testing.assert_array_equal(start, last)
        seen = []
        over = False
        while not over:
            seen.append(paths.target())
            over = paths.advance(np.zeros(2))
        assert len(seen) == 5
        np.testing.assert_allclose(seen[0], last + (seen[-1] - last) / 5, atol=1e-15)
        assert (seen[-1] == GOALS).all(axis=1).any()
        assert not np.array_equal(seen[-1], last)
        last = seen[-1]


def test_restored_paths_go_on() -> None:
    """A snapshot in the middle of a path continues it, and chooses the same goals after it."""
    paths, rng = GoalPaths(GOALS, 4), np.random.default_rng(1)
    paths.begin(np.zeros(2), np.zeros(2), rng)
    paths.advance(np.zeros(2))
    twin, twin_rng = GoalPaths.restore(paths.state()), np.random.default_rng(0)
    twin_rng.bit_generator.state = rng.bit_generator.state
    for _ in range(30):
        np.testing.assert_array_equal(paths.target(), twin.target())
        over = paths.advance(np.zeros(2))
        assert twin.advance(np.zeros(2)) == over
        if over:
            target = paths.goals[0]
            paths.begin(target, target, rng)
            twin.begin(target, target, twin_rng)


def test_goal_set_is_a_copy() -> None:
    """Changing the array that was passed in, or one that was given out, changes no goal."""
    goals = GOALS.copy()
    paths = GoalPaths(goals, 5)
    goals[:] = 7.0
    paths.goals[:] = 8.0
    np.testing.assert_array_equal(paths.goals, GOALS)


@pytest.mark.parametrize("goals", [[1.0, 2.0], [], [[0.0, np.nan], [1.0, 1.0]], [["a", "b"]]])
def test_refuses_what_is_no_goal_set(goals: list) -> None:
    """A goal set is a finite matrix."""
    with pytest.raises(InvalidArrayError, match="goals"):
        GoalPaths(goals, 5)


def test_refuses_a_position_behind_the_path() -> None:
    """A snapshot whose next step lies beyond the path is none."""
    state = GoalPaths(GOALS, 5).state()
    with pytest.raises(InvalidConfigError, match="next"):
        GoalPaths.restore(type(state)(state.arrays, {**state.settings, "next": 3}))
