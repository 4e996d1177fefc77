"""Movements: to goals and home, their order and their ends."""

import numpy as np
import pytest

from bha_goal_babbling.direction_sampling import DirectionTargets
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_paths import GoalPaths
from bha_goal_babbling.monitored_paths import MonitoredGoalPaths
from bha_goal_babbling.movements import Movements, restored_targets

GOALS = np.array([[0.5, 0.0], [0.0, 0.5], [0.5, 0.5]])
HOME_ACTION, HOME_OUTCOME = np.array([0.1, 0.2, 0.3]), np.array([0.2, 0.1])


def movements(home_probability: float = 0.5, steps: int = 4) -> Movements:
    """Return movements between three goals."""
    return Movements(GoalPaths(GOALS, steps), HOME_ACTION, HOME_OUTCOME, home_probability, steps)


def run(plan: Movements, count: int, seed: int = 0) -> list[bool]:
    """Make movements and return for each whether it went home."""
    rng = np.random.default_rng(seed)
    kinds = []
    while len(kinds) < count:
        plan.prepare(np.ones(3), np.ones(2), rng)
        going_home = plan.going_home
        if plan.advance(np.zeros(2)):
            kinds.append(going_home)
    return kinds


def test_never_home_first_nor_twice_running() -> None:
    """Learning starts at home, and from home there is no way home."""
    kinds = run(movements(1.0), 40)
    assert kinds == [False, True] * 20


def test_home_probability() -> None:
    """With p = 0.2 after each other movement, p / (1 + p) of all go home; both kinds count."""
    plan = movements(0.2)
    assert np.mean(run(plan, 6000)) == pytest.approx(0.2 / 1.2, abs=0.015)
    assert plan.count == 6000
    assert not any(run(movements(0.0), 200))


def test_rests_at_goals_and_not_on_the_way_home() -> None:
    """Every goal counts as met: four steps there, then two of rest, then home."""
    paths = MonitoredGoalPaths(GOALS, 4, HOME_OUTCOME, rest=2, rest_error=9.0)
    plan, rng = Movements(paths, HOME_ACTION, HOME_OUTCOME, 1.0, 3), np.random.default_rng(0)
    rests = []
    for _ in range(18):
        plan.prepare(np.ones(3), np.ones(2), rng)
        rests.append(plan.resting)
        plan.advance(np.zeros(2))
    assert rests == 2 * [*[False] * 4, True, True, *[False] * 3]


def test_home_path_is_straight_in_actions() -> None:
    """L steps from where the robot is; the last one is exactly home."""
    plan, rng = movements(1.0), np.random.default_rng(0)
    start = np.array([0.5, 0.2, 0.1])
    while not plan.going_home or plan.count == 0:
        plan.prepare(start, HOME_OUTCOME, rng)
        if not plan.going_home:
            plan.advance(np.zeros(2))
    steps = []
    over = False
    while not over:
        steps.append(plan.home_step)
        over = plan.advance(np.zeros(2))
    assert len(steps) == 4
    np.testing.assert_allclose(np.diff([start, *steps], axis=0), [(HOME_ACTION - start) / 4] * 4)
    np.testing.assert_array_equal(steps[-1], HOME_ACTION)


def test_path_after_home_starts_at_the_home_outcome() -> None:
    """Its first step is a quarter of the way from home to the goal."""
    plan, rng = movements(1.0), np.random.default_rng(1)
    for _ in range(8):  # to a goal and home
        plan.prepare(HOME_ACTION, np.array([9.0, 9.0]), rng)
        plan.advance(np.zeros(2))
    plan.prepare(HOME_ACTION, np.array([9.0, 9.0]), rng)
    first = plan.target_step
    for _ in range(3):
        plan.advance(np.zeros(2))
    np.testing.assert_allclose(HOME_OUTCOME + 4 * first, plan.target)
    assert (plan.target == GOALS).all(axis=1).any()


def test_steps_add_up_across_movements() -> None:
    """Intended steps sum to the last target: none is lost where one path follows another."""
    plan, rng = movements(0.0), np.random.default_rng(2)
    total = np.zeros(2)
    for _ in range(50):
        plan.prepare(np.ones(3), np.ones(2), rng)
        total += plan.target_step
        target = plan.target
        plan.advance(np.zeros(2))
        np.testing.assert_allclose(HOME_OUTCOME + total, target, atol=1e-12)


def test_directions_count_from_the_outcome() -> None:
    """Thrown back, a direction starts at what was observed, and its first step is one step."""
    targets = DirectionTargets(0.1, 2)
    plan, rng = Movements(targets, HOME_ACTION, HOME_OUTCOME, 0.0, 4), np.random.default_rng(3)
    plan.prepare(HOME_ACTION, HOME_OUTCOME, rng)
    assert plan.advance(-plan.target_step)
    observed = np.array([0.7, -0.2])
    plan.prepare(HOME_ACTION, observed, rng)
    np.testing.assert_allclose(plan.target - observed, plan.target_step)
    assert np.linalg.norm(plan.target_step) == pytest.approx(0.1)


def test_restored_movements_go_on() -> None:
    """A snapshot in the middle of any movement continues it, and chooses the same ones after."""
    plan, rng = movements(0.4), np.random.default_rng(5)
    for cut in range(60):
        plan.prepare(np.full(3, 0.1 * cut), np.full(2, 0.1 * cut), rng)
        twin = Movements(restored_targets(plan.state()), HOME_ACTION, HOME_OUTCOME, 0.4, 4)
        twin.load(plan.state())
        assert twin.going_home == plan.going_home
        np.testing.assert_array_equal(twin.target_step, plan.target_step)
        if plan.going_home:
            np.testing.assert_array_equal(twin.home_step, plan.home_step)
        assert twin.advance(np.zeros(2)) == plan.advance(np.zeros(2))
        assert twin.count == plan.count


def test_refuses_unknown_targets() -> None:
    """The message lists the known kinds."""
    state = movements().state()
    with pytest.raises(InvalidConfigError, match="goal_paths"):
        restored_targets(type(state)(state.arrays, {**state.settings, "targets_kind": "magic"}))
