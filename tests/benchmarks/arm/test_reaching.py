"""The shared task on arms, and how long a learner takes with it."""

import numpy as np
import pytest

from benchmarks.arm.reaching import ReachingTask, TimeToReach, time_to_reach
from bha_goal_babbling.babbler_config import GoalBabblerConfig


def test_the_task_is_the_one_that_figures_are_compared_on() -> None:
    task = ReachingTask(10)
    assert task.goals.shape == (77, 2)
    np.testing.assert_allclose(task.goals.min(axis=0), [0.2, -0.5])
    np.testing.assert_allclose(task.goals.max(axis=0), [0.8, 0.5])
    np.testing.assert_allclose(task.home_outcome, [0.7, 0.0], atol=1e-12)
    np.testing.assert_allclose(task.limits, np.pi)


def test_errors_are_distances_from_the_goals() -> None:
    """An inverse that always answers home misses each goal by its distance from home."""
    task = ReachingTask(3)
    errors = task.errors(lambda goals: np.tile(task.home_action, (len(goals), 1)))
    np.testing.assert_allclose(errors, np.linalg.norm(task.goals - [0.7, 0.0], axis=1), atol=1e-12)


@pytest.mark.parametrize("every_sample", [False, True])
def test_time_is_when_the_error_first_was_down(every_sample: bool) -> None:
    """A second learner that is stopped just before has a larger error."""
    task, config = ReachingTask(3), GoalBabblerConfig.rls()
    learner = task.babbler(config, 0)
    first = task.errors(learner.inverse).mean()
    needed = time_to_reach(task, learner, most_samples=2000, every_sample=every_sample)
    assert needed == TimeToReach(learner.samples, learner.movements)
    assert needed.samples is not None
    assert task.errors(learner.inverse).mean() <= 0.1 * first
    if every_sample:
        twin = task.babbler(config, 0)
        for _ in range(needed.samples - 1):
            action = twin.ask()
            twin.tell(action, task.arm.forward(action))
        assert task.errors(twin.inverse).mean() > 0.1 * first


def test_a_run_that_does_not_get_there_ends() -> None:
    task = ReachingTask(3)
    learner = task.babbler(GoalBabblerConfig(learning_rate=1e-6), 0)
    assert time_to_reach(task, learner, most_movements=4) == TimeToReach(None, None)
    assert learner.movements == 4
    with pytest.raises(ValueError, match="most_samples or most_movements"):
        time_to_reach(task, learner)
