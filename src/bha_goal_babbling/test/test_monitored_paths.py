"""Paths with an account of errors: giving up, going on, and which goal comes next."""

import numpy as np
import pytest

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.monitored_paths import MonitoredGoalPaths
from bha_goal_babbling.target_source import TargetSource

GOALS = np.array([[1.0, 0.0], [0.0, 2.0], [3.0, 0.0], [0.0, 0.0]])
HOME, STILL = np.zeros(2), np.zeros(2)


def paths(candidates: int = 1, abort_distance: float | None = 0.5) -> MonitoredGoalPaths:
    return MonitoredGoalPaths(GOALS, 5, HOME, candidates, abort_distance)


def finish(source: MonitoredGoalPaths, miss: float) -> int:
    """Follow the path, each outcome `miss` beside its target, and return the number of steps."""
    steps = 1
    while not source.advance(STILL, source.target() + np.array([0.0, miss])):
        steps += 1
    return steps


def test_is_a_source_of_targets() -> None:
    assert isinstance(paths(), TargetSource)


def test_first_errors_are_the_distances_from_home() -> None:
    """At the start the inverse model answers every goal with home."""
    np.testing.assert_array_equal(paths().errors, [1.0, 2.0, 3.0, 0.0])


def test_a_path_on_track_ends_at_its_goal() -> None:
    """The miss at its last step is the goal's error from then on; other goals keep theirs."""
    source, rng = paths(), np.random.default_rng(0)
    start = source.begin(HOME, np.array([9.0, 9.0]), rng)
    np.testing.assert_array_equal(start, HOME)
    before = source.errors
    assert finish(source, 0.2) == 5
    assert source.goal_error == pytest.approx(0.2)
    assert np.count_nonzero(source.errors != before) == 1


def test_it_may_stay_at_its_goal() -> None:
    """The error is that of the last step there."""
    source = MonitoredGoalPaths(GOALS, 5, HOME, 1, None, stay=3)
    source.begin(HOME, HOME, np.random.default_rng(0))
    misses = np.linspace(0.8, 0.1, 8)
    for number, miss in enumerate(misses):
        assert not source.resting
        over = source.advance(STILL, source.target() + np.array([0.0, miss]))
        assert over == (number == 7)
    assert source.goal_error == pytest.approx(0.1)


@pytest.mark.parametrize(("miss", "steps"), [(0.3 - 1e-9, 5 + 4), (0.3 + 1e-9, 5 + 2)])
def test_it_rests_at_goals_that_were_met(miss: float, steps: int) -> None:
    """By the error of the time before, not by that of this time; on the way there is no rest."""
    goals = GOALS[[0, 0]]
    source = MonitoredGoalPaths(goals, 5, HOME, 2, None, stay=2, rest=4, rest_error=0.3)
    rng = np.random.default_rng(0)
    for _ in goals:  # with the larger error first, each comes once
        source.begin(HOME, HOME, rng)
        while True:
            assert not source.resting
            if source.advance(STILL, source.target() + np.array([0.0, miss])):
                break
    source.begin(HOME, HOME, rng)
    rests = [source.resting]
    while not source.advance(STILL, source.target() + np.array([0.0, 0.6 - miss])):
        rests.append(source.resting)
    assert len(rests) == steps
    assert rests == [False] * 5 + [steps == 9] * (steps - 5)


@pytest.mark.parametrize(("miss", "steps"), [(0.5 - 1e-9, 5), (0.5 + 1e-9, 1)])
def test_a_path_is_given_up_beyond_the_distance(miss: float, steps: int) -> None:
    source = paths()
    source.begin(HOME, HOME, np.random.default_rng(0))
    assert finish(source, miss) == steps
    assert source.goal_error == pytest.approx(miss)


def test_after_giving_up_it_goes_on_from_what_was_observed() -> None:
    """The line to the next goal starts there, and the one after that at its goal as usual."""
    source, rng = paths(), np.random.default_rng(0)
    source.begin(HOME, HOME, rng)
    finish(source, 0.7)
    observed = np.array([0.3, 0.7])
    start = source.begin(np.array([5.0, 5.0]), observed, rng)
    np.testing.assert_array_equal(start, observed)
    first = source.target()
    finish(source, 0.0)
    goal = source.target() if source.goal_error != 0.0 else GOALS[np.argmin(source.errors)]
    assert np.linalg.norm(first - observed) <= np.linalg.norm(GOALS - observed, axis=1).max() / 5
    np.testing.assert_array_equal(source.begin(goal, observed, rng), goal)


def test_without_a_distance_it_never_gives_up() -> None:
    source = paths(abort_distance=None)
    source.begin(HOME, HOME, np.random.default_rng(0))
    assert finish(source, 100.0) == 5


def test_outcomes_that_are_not_trusted_are_no_errors() -> None:
    """The path goes on to its end without them."""
    source = paths()
    source.begin(HOME, HOME, np.random.default_rng(0))
    before = source.errors
    assert [source.advance(STILL) for _ in range(5)] == [False] * 4 + [True]
    np.testing.assert_array_equal(source.errors, before)


def test_what_is_missed_comes_more_often() -> None:
    """With two of four drawn, goal 2, always missed, is begun most, and no other one is left."""
    source, rng = paths(candidates=2, abort_distance=None), np.random.default_rng(0)
    counts = np.zeros(4, dtype=int)
    for _ in range(2000):
        source.begin(HOME, HOME, rng)
        goal = source._choice.last
        counts[goal] += 1
        finish(source, 1.0 if goal == 2 else 0.01 * goal)
    assert counts.argmax() == 2
    assert counts.min() > 100


@pytest.mark.parametrize("aborted", [False, True])
def test_restored_paths_go_on(aborted: bool) -> None:
    """Errors, position, and whether the last path was given up, are in the snapshot."""
    source = MonitoredGoalPaths(GOALS, 5, HOME, 3, 0.5, stay=1, rest=3, rest_error=0.2)
    rng = np.random.default_rng(1)
    source.begin(HOME, HOME, rng)
    if aborted:
        finish(source, 0.9)
    else:
        source.advance(STILL, source.target())
    twin, twin_rng = MonitoredGoalPaths.restore(source.state()), np.random.default_rng(0)
    twin_rng.bit_generator.state = rng.bit_generator.state
    for number in range(60):
        over = aborted and number == 0
        if not over:
            np.testing.assert_array_equal(twin.target(), source.target())
            assert twin.resting == source.resting
            outcome = source.target() + np.array([0.01 * number, 0.0])
            over = source.advance(STILL, outcome)
            assert twin.advance(STILL, outcome) == over
        if over:
            seen = np.array([0.1 * number, 0.3])
            np.testing.assert_array_equal(
                twin.begin(HOME, seen, twin_rng), source.begin(HOME, seen, rng)
            )
        np.testing.assert_array_equal(twin.errors, source.errors)


@pytest.mark.parametrize(
    "wrong",
    [
        {"candidates": 0},
        {"abort_distance": 0.0},
        {"steps": 0},
        {"goals": GOALS[:1]},
        {"stay": -1},
        {"rest": -1},
        {"rest_error": -0.1},
        {"rest_error": np.nan},
    ],
)
def test_refuses_settings_out_of_range(wrong: dict) -> None:
    with pytest.raises(InvalidConfigError, match=r"must|at least|needs"):
        MonitoredGoalPaths(**{"goals": GOALS, "steps": 5, "home_outcome": HOME, **wrong})


@pytest.mark.parametrize("wrong", [{"next": 6}, {"last_goal": 4}])
def test_refuses_snapshots_beyond_the_ends(wrong: dict) -> None:
    state = paths().state()
    with pytest.raises(InvalidConfigError, match=r"next|last"):
        MonitoredGoalPaths.restore(type(state)(state.arrays, {**state.settings, **wrong}))
