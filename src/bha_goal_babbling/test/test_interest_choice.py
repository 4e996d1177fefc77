"""Goal choice by interest: the formula on errors made by hand, the draw, snapshots."""

import numpy as np
import pytest

from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.goal_paths import GoalPaths
from bha_goal_babbling.interest_choice import InterestGoalChoice
from bha_goal_babbling.planar_arm import PlanarArm


def reported(errors: list[list[float]], **settings: float) -> InterestGoalChoice:
    choice = InterestGoalChoice(len(errors), 4, **settings)
    for goal, series in enumerate(errors):
        for error in series:
            choice.report(goal, error)
    return choice


def test_interest_is_the_formula() -> None:
    """Falling, rising, steady and unvisited goals, worked out by hand."""
    choice = reported([[8, 8, 4, 4], [1, 1, 3, 3], [2, 2, 2, 2], []], error_share=0.25)
    # Errors 4, 3, 2 of at most 4; progress 4 of 4; regress 2 of 2.
    expected = [0.25 + 0.75 * 0.5, 0.25 * 0.75 + 0.75 * 0.5, 0.25 * 0.5, 0.25]
    np.testing.assert_allclose(choice.interest(), expected)


def test_shares_set_what_counts() -> None:
    """All on progress leaves only the falling goal, all on regress only the rising one."""
    errors = [[8.0, 4.0], [1.0, 3.0], [2.0, 2.0]]
    progress = reported(errors, error_share=0.0, progress_share=1.0)
    regress = reported(errors, error_share=0.0, progress_share=0.0)
    np.testing.assert_allclose(progress.interest(), [1.0, 0.0, 0.0])
    np.testing.assert_allclose(regress.interest(), [0.0, 1.0, 0.0])


def test_only_the_window_counts() -> None:
    """Visits older than the window are forgotten."""
    recent = [5.0, 4.0, 3.0, 2.0]
    np.testing.assert_array_equal(
        reported([[9.0, 0.0, 7.0, *recent], [1.0]]).interest(),
        reported([recent, [1.0]]).interest(),
    )


def test_draws_in_proportion_to_interest_but_not_the_last() -> None:
    """Errors 4, 2, 2, 2 make the first goal twice as likely; the last one never comes."""
    rng = np.random.default_rng(0)
    choice = reported([[4.0], [2.0], [2.0], [2.0]])
    drawn = []
    for _ in range(8000):
        choice.last = 3
        drawn.append(choice.choose(rng))
    counts = np.bincount(drawn, minlength=4)
    assert counts[3] == 0
    np.testing.assert_allclose(counts[:3], [4000, 2000, 2000], rtol=0.1)


def test_without_any_error_all_others_are_alike() -> None:
    """Interest of zero everywhere is no reason to stop."""
    rng = np.random.default_rng(0)
    choice = reported([[0.0], [0.0], [0.0]])
    drawn = [choice.choose(rng) for _ in range(300)]
    assert set(drawn) == {0, 1, 2}
    assert (np.diff(drawn) != 0).all()


def test_paths_report_how_far_off_the_goal_they_ended() -> None:
    """The error of the goal just visited is the distance of the outcome from it."""
    goals = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    choice, rng = InterestGoalChoice(3), np.random.default_rng(0)
    paths = GoalPaths(goals, 2, choice)
    outcome = np.array([0.5, 0.5])
    paths.begin(outcome, outcome, rng)
    assert paths.goal_error == np.inf
    goal = goals[choice.last]
    miss = np.array([0.3, 0.4])
    np.testing.assert_allclose(paths.target(), 0.5 * (outcome + goal))
    assert not paths.advance(0.5 * (goal + miss - outcome))
    np.testing.assert_array_equal(paths.target(), goal)
    assert paths.advance(0.5 * (goal + miss - outcome))
    assert paths.goal_error == pytest.approx(0.5)


def test_a_restored_learner_chooses_the_same_goals() -> None:
    """A snapshot in the middle of a movement continues bit for bit."""
    arm = PlanarArm(3)
    goals, home, limits = arm.goal_grid(), arm.home(), np.full(3, np.pi)
    config = GoalBabblerConfig(path_steps=5)
    babbler = GoalBabbler(
        config,
        GoalPaths(goals, config.path_steps, InterestGoalChoice(len(goals))),
        home,
        arm.forward(home),
        -limits,
        limits,
        np.random.default_rng(0),
    )
    for _ in range(303):
        action = babbler.ask()
        babbler.tell(action, arm.forward(action))
    twin = GoalBabbler.restore(babbler.state())
    for _ in range(200):
        action = babbler.ask()
        np.testing.assert_array_equal(action, twin.ask())
        babbler.tell(action, arm.forward(action))
        twin.tell(action, arm.forward(action))


@pytest.mark.parametrize(
    "settings",
    [
        {"count": 1},
        {"count": 3, "window": 1},
        {"count": 3, "error_share": 1.5},
        {"count": 3, "progress_share": -0.1},
    ],
)
def test_refuses_impossible_settings(settings: dict) -> None:
    """There must be something to choose from, and to compare."""
    with pytest.raises(InvalidConfigError, match="must be"):
        InterestGoalChoice(**settings)
