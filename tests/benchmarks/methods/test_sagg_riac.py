"""SAGG-RIAC: progress of competence, splits where it differs, goals where it is."""

import numpy as np
import pytest

from benchmarks.methods.sagg_riac import SaggRiac, competence_progress
from benchmarks.methods.sagg_riac_paths import SaggRiacPaths
from bha_goal_babbling.target_source import TargetSource

LOW, HIGH = np.zeros(2), np.ones(2)


def after_progress_on_the_left(seed: int, goals: int) -> SaggRiac:
    """Return regions after goals whose error falls where the first coordinate is below 0.4."""
    rng = np.random.default_rng(seed)
    choice = SaggRiac(LOW, HIGH, rng)
    for index in range(goals):
        goal = rng.uniform(LOW, HIGH)
        choice.report(goal, 1.0 - index / goals if goal[0] < 0.4 else 1.0)
    return choice


def test_progress_is_the_change_of_the_mean() -> None:
    assert competence_progress(np.array([9.0, -4.0, -4.0, -1.0, -2.0]), 4) == pytest.approx(2.5)
    assert competence_progress(np.array([-1.0, -4.0]), 4) == pytest.approx(3.0)
    assert competence_progress(np.array([-1.0]), 4) == 0.0


def test_splits_where_progress_differs() -> None:
    """The first cut is across the first axis, near 0.4, in nearly every case."""
    good = 0
    for seed in range(20):
        choice = after_progress_on_the_left(seed, 100)
        assert len(choice.regions) == 2
        lower = choice.regions[0]
        good += lower.high[1] == 1.0 and 0.2 < lower.high[0] < 0.6
    assert good >= 18


def test_regions_tile_the_box_and_hold_their_goals() -> None:
    choice = after_progress_on_the_left(0, 2000)
    assert len(choice.regions) > 10
    assert sum(region.volume for region in choice.regions) == pytest.approx(1.0)
    assert sum(len(region.goals) for region in choice.regions) == 2000
    for region in choice.regions:
        assert all(region.holds(goal) for goal in region.goals)
        assert len(region.goals) < 100


def test_prefers_the_region_with_progress() -> None:
    """Most goals are drawn where the error falls, though it is less than half of the box."""
    choice = after_progress_on_the_left(1, 1000)
    rng = np.random.default_rng(0)
    goals = np.array([choice.choose(rng) for _ in range(500)])
    assert (goals >= LOW).all()
    assert (goals <= HIGH).all()
    assert (goals[:, 0] < 0.4).mean() > 0.7
    # Without progress anywhere volume alone decides.
    flat = SaggRiac(LOW, HIGH, np.random.default_rng(0))
    for goal in rng.uniform(LOW, HIGH, (1000, 2)):
        flat.report(goal, 1.0)
    goals = np.array([flat.choose(rng) for _ in range(500)])
    assert (goals[:, 0] < 0.4).mean() == pytest.approx(0.4, abs=0.08)


def test_paths_lead_to_the_goal_and_report_the_miss() -> None:
    rng = np.random.default_rng(2)
    paths = SaggRiacPaths(LOW, HIGH, 5)
    assert isinstance(paths, TargetSource)
    start = np.array([0.5, 0.5])
    paths.begin(start, start, rng)
    goal = start + 5.0 * (paths.target() - start)
    # All that is missed is missed in the last step.
    steps = [0.2 * (goal - start)] * 4 + [0.2 * (goal - start) + np.array([0.06, 0.08])]
    assert [paths.advance(step) for step in steps] == [False] * 4 + [True]
    region = paths.choice.regions[0]
    np.testing.assert_allclose(region.goals, [goal], atol=1e-12)
    assert region.competences == [pytest.approx(-0.1)]


def test_restored_paths_go_on() -> None:
    """The same reports make the same regions, and with the same generator the same goals."""
    rng = np.random.default_rng(3)
    paths = SaggRiacPaths(LOW, HIGH, 2, seed=5)
    position = np.full(2, 0.5)
    for _ in range(250):
        paths.begin(position, position, rng)
        over = False
        while not over:
            over = paths.advance(0.3 * (paths.target() - position))
    twin = SaggRiacPaths.restore(paths.state())
    assert len(paths.choice.regions) > 2
    for mine, other in zip(paths.choice.regions, twin.choice.regions, strict=True):
        np.testing.assert_array_equal(mine.low, other.low)
        assert mine.competences == other.competences
    first, second = np.random.default_rng(4), np.random.default_rng(4)
    for _ in range(20):
        np.testing.assert_array_equal(paths.choice.choose(first), twin.choice.choose(second))
