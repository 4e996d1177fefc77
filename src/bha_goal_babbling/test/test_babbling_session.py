"""A stretch of goal babbling, on a robot that is where it is told to be."""

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbling_session import BabblingSession, NotFollowingError
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.observation_window import Observation
from bha_goal_babbling.task import Task, load_task

TASK = load_task(Path(__file__).parents[1] / "config" / "task_2d.yaml")
PERIOD = 0.5
ANGLES = 2.0 * np.pi * np.arange(9) / 3


def tip_of(lengths: FloatArray) -> FloatArray:
    """Return where the tip of a trunk with these lengths is, smoothly, (3,) [m]."""
    lever = np.repeat([6.0, 4.0, 2.0], 3)
    bend = np.tanh(np.stack([np.cos(ANGLES), np.sin(ANGLES)]) * lever @ (lengths - 0.195))
    return np.array([0.5 * bend[0], 0.5 * bend[1], 0.2 + lengths.mean() * 3 - 0.1 * bend @ bend])


def see(lengths: FloatArray) -> Observation:
    return Observation(lengths, tip_of(lengths))


def session(
    duration: float,
    babbler: GoalBabbler | None = None,
    on_sample: Callable[[FloatArray, FloatArray], None] | None = None,
    task: Task = TASK,
    **changes: Any,
) -> BabblingSession:
    settings = LearnerSettings(**{"command_period": PERIOD, "settling_time": 3.0, **changes})
    rng = np.random.default_rng(7)
    return BabblingSession(task, settings, duration, babbler, rng, on_sample)


def run(running: BabblingSession) -> FloatArray:
    """Run to the end; return all commands, shape (periods, 9)."""
    lengths, commands = np.full(9, 0.18), []
    while not running.done:
        lengths = running.update(see(lengths))
        commands.append(lengths)
    return np.array(commands)


@pytest.mark.parametrize(
    ("duration", "periods"), [(0.1, 1), (0.5, 1), (0.6, 2), (30.0, 60), (30.0001, 61)]
)
def test_lasts_as_long_as_asked(duration: float, periods: int) -> None:
    running = session(duration)
    assert len(run(running)) == periods
    assert running.elapsed == periods * PERIOD


def test_goes_home_first_and_waits_there() -> None:
    running = session(60.0, settling_time=3.0)
    lengths = np.full(9, 0.18)
    for period in range(6):
        assert running.settling
        lengths = running.update(see(lengths))
        np.testing.assert_array_equal(lengths, TASK.home_action)
        assert running.babbler is None
        assert running.elapsed == (period + 1) * PERIOD
    running.update(see(lengths))
    assert not running.settling
    assert running.babbler is not None
    np.testing.assert_array_equal(running.babbler.home_outcome, TASK.outcome(tip_of(lengths)))


def test_exploration_that_goes_on_begins_at_rest() -> None:
    """Whatever the robot did in between, it has come to rest at the step it goes on with."""
    first = session(60.0)
    run(first)
    assert first.babbler is not None
    assert len(first.babbler.state().arrays["body_forward_history"]) == 2
    again = session(60.0, first.babbler)
    assert len(first.babbler.state().arrays["body_forward_history"]) == 0
    np.testing.assert_array_equal(again.update(see(TASK.home_action)), first.babbler.ask())


def test_every_step_is_told_what_came_of_it() -> None:
    samples: list[tuple[FloatArray, FloatArray]] = []
    running = session(30.0, on_sample=lambda *sample: samples.append(sample))
    commands = run(running)
    assert running.babbler is not None
    assert len(samples) == running.babbler.samples == len(commands) - 7
    for command, (lengths, outcome) in zip(commands[6:], samples, strict=False):
        np.testing.assert_array_equal(lengths, command)
        np.testing.assert_array_equal(outcome, TASK.outcome(tip_of(command)))


@pytest.mark.parametrize("periods", [1, 2, 5])
def test_a_step_lasts_its_periods(periods: int) -> None:
    commands = run(session(60.0, step_periods=periods))[6:]
    changes = np.flatnonzero(np.any(np.diff(commands, axis=0) != 0.0, axis=1)) + 1
    assert len(changes) > 5
    np.testing.assert_array_equal(changes % periods, 0)


def test_commands_are_within_the_limits() -> None:
    commands = run(session(600.0))
    assert (commands >= TASK.action_low).all()
    assert (commands <= TASK.action_high).all()


def test_learns() -> None:
    """After 20 minutes on this easy robot, goals are reached within 2 cm on average."""
    running = session(1200.0)
    run(running)
    assert running.babbler is not None
    goals = TASK.goals()
    reached = np.array([TASK.outcome(tip_of(q)) for q in running.babbler.inverse(goals)])
    assert np.linalg.norm(reached - goals, axis=1).mean() < 0.02


def test_without_a_tip_nothing_is_told_and_the_robot_waits() -> None:
    running = session(60.0)
    lengths = TASK.home_action
    for _ in range(20):
        lengths = running.update(see(lengths))
    assert running.babbler is not None
    samples = running.babbler.samples
    for _ in range(10):
        np.testing.assert_array_equal(running.update(Observation(lengths, None)), lengths)
    assert running.babbler.samples == samples
    after = running.update(see(lengths))
    assert running.babbler.samples == samples + 1
    assert not np.array_equal(after, lengths)


@pytest.mark.parametrize("wrong", [1e200, np.inf, np.nan])
@pytest.mark.parametrize("which", ["lengths", "tip"])
def test_absurd_readings_are_as_good_as_none(wrong: float, which: str) -> None:
    running = session(60.0)
    lengths = TASK.home_action
    for _ in range(20):
        lengths = running.update(see(lengths))
    assert running.babbler is not None
    samples = running.babbler.samples
    seen = {"lengths": lengths.copy(), "tip": tip_of(lengths)}
    seen[which][1] = wrong
    np.testing.assert_array_equal(running.update(Observation(**seen)), lengths)
    assert running.babbler.samples == samples
    running.update(see(lengths))
    assert running.babbler.samples == samples + 1


def test_time_goes_on_without_a_tip() -> None:
    running = session(10.0)
    for period in range(20):
        assert not running.done
        running.update(Observation(TASK.home_action, None))
        assert running.elapsed == (period + 1) * PERIOD
    assert running.done
    assert running.babbler is None


@pytest.mark.parametrize("missing", [0, 1, 9])
def test_a_robot_that_does_not_follow(missing: int) -> None:
    """It is found out at the first tip after the time to settle, when that may come."""
    running = session(60.0, following_tolerance=0.02)
    lengths = TASK.home_action - 0.021
    for _ in range(6):
        running.update(see(lengths))
    for _ in range(missing):
        running.update(Observation(lengths, None))
    with pytest.raises(NotFollowingError, match=r"21 mm from the command on average after 3 s"):
        running.update(see(lengths))
    assert running.babbler is None


def test_a_robot_that_follows_well_enough() -> None:
    running = session(60.0, following_tolerance=0.02)
    for _ in range(10):
        running.update(see(TASK.home_action - 0.019))
    assert running.babbler is not None


def test_the_exploration_itself_may_lag_behind() -> None:
    """Later on a slow robot is no reason to end: what is measured is what is learned."""
    running = session(60.0)
    lengths = TASK.home_action
    for _ in range(10):
        lengths = running.update(see(lengths))
    for _ in range(10):
        running.update(see(TASK.home_action - 0.05))


@pytest.mark.parametrize("first", [3.5, 4.0, 10.0, 55.5])
def test_goes_on_with_the_very_step_it_was_at(first: float) -> None:
    """Two sessions make the commands of one, apart from the time to settle.

    Without a body model, which takes note of the rest.
    """
    plain = dataclasses.replace(TASK, config=dataclasses.replace(TASK.config, forward_model="none"))
    whole = run(session(100.0, task=plain))
    begun = session(first, task=plain)
    commands = run(begun)
    np.testing.assert_array_equal(commands, whole[: len(commands)])
    again = session(100.0, begun.babbler)
    continued = run(again)
    np.testing.assert_array_equal(continued[:6], np.tile(commands[-1], (6, 1)))
    rest = whole[len(commands) :]
    np.testing.assert_array_equal(continued[6 : 6 + len(rest)], rest)
