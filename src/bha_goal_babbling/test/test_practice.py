"""Examples out of movements to other people's goals."""

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.learner import Learner
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.observation_window import Observation
from bha_goal_babbling.practice import Practice
from bha_goal_babbling.task import find_task

TASK = find_task("2d")
SETTINGS = LearnerSettings(rest_time=1.0, command_period=0.5, learn_in_use="everything")


def babbler(seed: int = 0) -> GoalBabbler:
    return GoalBabbler(
        TASK.config,
        TASK.goals(),
        TASK.home_action,
        np.zeros(2),
        TASK.action_low,
        TASK.action_high,
        np.random.default_rng(seed),
    )


def seen(x: float, bend: float = 0.0) -> Observation:
    """Return the tip at x [m] off the axis, and lengths that differ by `bend` [m]."""
    lengths = TASK.home_action + bend * np.array([1.0, -0.5, -0.5] * 3)
    return Observation(lengths, np.array([x, 0.0, 0.78]))


def moved(practice: Practice, learns: GoalBabbler, way: list[float]) -> int:
    before = practice.examples
    for x in way:
        practice.see(learns, seen(x, -x / 6.0))
    return practice.examples - before


def test_a_movement_is_learned_step_by_step_and_once_at_rest() -> None:
    practice, learns = Practice(TASK, SETTINGS), babbler()
    practice.begin()
    assert moved(practice, learns, [0.0, 0.05, 0.1, 0.15]) == 3
    assert moved(practice, learns, [0.15] * 10) == 1
    assert np.linalg.norm(learns.inverse([0.15, 0.0]) - seen(0.15, -0.025).lengths) < 0.01


def test_a_robot_that_stands_still_teaches_nothing() -> None:
    practice, learns = Practice(TASK, SETTINGS), babbler()
    practice.begin()
    moved(practice, learns, [0.0, 0.05] + [0.05] * 10)
    before = learns.inverse(TASK.goals())
    assert moved(practice, learns, [0.05] * 1000) == 0
    assert np.array_equal(learns.inverse(TASK.goals()), before)


def test_what_moves_without_a_goal_is_not_learned() -> None:
    practice, learns = Practice(TASK, SETTINGS), babbler()
    assert moved(practice, learns, [0.0, 0.05, 0.1]) == 0
    practice.begin()
    practice.end()
    assert moved(practice, learns, [0.0, 0.05, 0.1]) == 0


@pytest.mark.parametrize("tip", [None, np.full(3, np.nan), np.full(3, 1e300)])
def test_a_tip_that_is_missing_or_absurd_is_passed_over(tip: FloatArray | None) -> None:
    practice, learns = Practice(TASK, SETTINGS), babbler()
    practice.begin()
    moved(practice, learns, [0.0])
    practice.see(learns, Observation(TASK.home_action, tip))
    assert practice.examples == 0
    assert moved(practice, learns, [0.05]) == 1


def test_exploration_goes_on_with_the_step_it_was_at() -> None:
    learns = babbler()
    asked = learns.ask()
    learns.practise(seen(0.1, -0.02).lengths, [0.1, 0.0])
    assert np.array_equal(learns.ask(), asked)
    assert learns.samples == 0
    learns.tell(asked, [0.0, 0.0])


@pytest.mark.parametrize("lesson", ["nothing", "offsets", "everything"])
def test_the_learner_takes_from_use_what_it_is_told_to(lesson: str) -> None:
    settings = LearnerSettings(learn_in_use=lesson, command_period=0.5)
    learner = Learner(settings, TASK, babbler())
    assert learner.babbler is not None
    for x in np.linspace(-0.1, 0.1, 20):  # a body that knows nothing tells nothing of offsets
        learner.babbler.practise(seen(x, -x / 6.0).lengths, [x, 0.0])
    learner.babbler.pause()
    before = learner.babbler.state().arrays
    period = 500_000_000
    for tick in range(1, 40):
        if tick == 3:
            learner.go_to(np.array([0.2, 0.0, 0.78]))
        x = 0.02 * min(max(tick - 3, 0), 10)
        observation = seen(x, -x / 6.0)
        assert observation.tip is not None
        learner.see_lengths(tick * period, observation.lengths)
        learner.see_tip(tick * period, observation.tip)
        learner.update(tick * period)
    assert (learner.practised >= 10) == (lesson != "nothing")
    after = learner.babbler.state().arrays
    changed = {
        name for name in before if not np.array_equal(before[name], after[name], equal_nan=True)
    }
    offsets = {"body_offsets_values", "body_offsets_covariance"}
    if lesson == "everything":
        assert changed > offsets
    else:
        assert changed == (offsets if lesson == "offsets" else set())
