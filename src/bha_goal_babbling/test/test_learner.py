"""The whole learner: what it does when, what it refuses, and that interruptions change nothing."""

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.learner import Learner, RefusedError
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.reach import Reach
from bha_goal_babbling.task import Task, load_task

CONFIG = Path(__file__).parents[1] / "config"
TASK = load_task(CONFIG / "task_2d.yaml")
PLAIN = dataclasses.replace(TASK, config=dataclasses.replace(TASK.config, forward_model="none"))
PERIOD = 500_000_000  # [ns]
ANGLES = 2.0 * np.pi * np.arange(9) / 3
GOAL = np.array([0.1, -0.1, 0.75])


def tip_of(lengths: FloatArray) -> FloatArray:
    """Return where the tip of a trunk with these lengths is, smoothly, (3,) [m]."""
    lever = np.repeat([6.0, 4.0, 2.0], 3)
    bend = np.tanh(np.stack([np.cos(ANGLES), np.sin(ANGLES)]) * lever @ (lengths - 0.195))
    return np.array([0.5 * bend[0], 0.5 * bend[1], 0.2 + lengths.mean() * 3 - 0.1 * bend @ bend])


class Robot:
    """A robot that is where it is told to be, and a learner that commands it."""

    def __init__(
        self, babbler: GoalBabbler | None = None, task: Task = TASK, **changes: Any
    ) -> None:
        settings = LearnerSettings(
            **{"settling_time": 3.0, "rest_time": 2.0, "observation_span": 0.1, **changes}
        )
        self.learner = Learner(settings, task, babbler)
        self.time = 0
        self.lengths = np.full(9, 0.19)
        self.longest = np.full(9, np.inf)
        self.shift = np.zeros(9)  # what its sensors read too much [m]
        self.tracked = True
        self.follows = True
        self.commands: list[FloatArray] = []

    def step(self, periods: int = 1) -> FloatArray:
        """Go on by command periods; return the last command."""
        for _ in range(periods):
            self.time += PERIOD
            self.learner.see_lengths(self.time, self.lengths + self.shift)
            if self.tracked:
                self.learner.see_tip(self.time, tip_of(self.lengths))
            command = self.learner.update(self.time)
            assert command is not None
            self.commands.append(command.copy())
            if self.follows:
                self.lengths = np.minimum(self.commands[-1] - self.shift, self.longest)
        return self.commands[-1]

    def babble(self, duration: float, **options: Any) -> int:
        """Babble to the end; return how many commands it took."""
        self.learner.babble(duration, **options)
        before = len(self.commands)
        while self.learner.session is not None:
            self.step()
        return len(self.commands) - before

    def end(self, movement: Reach) -> None:
        """Go on until a movement has ended."""
        for _ in range(1000):
            if self.learner.reach is not movement:
                return
            self.step()
        raise AssertionError("the movement did not end")


def taught(seconds: float = 60.0) -> Robot:
    """Return a robot that has explored a little."""
    robot = Robot()
    robot.babble(seconds)
    return robot


def distance(lengths: FloatArray, goal: FloatArray) -> float:
    """Return how far from a goal a robot of these lengths is, aside [m]."""
    return float(np.linalg.norm(tip_of(lengths)[:2] - goal[:2]))


def shortened(**changes: Any) -> tuple[Robot, FloatArray]:
    """Return a taught robot, one bellows of which now ends short of what `GOAL` takes.

    Also the lengths (9,) [m] at which it ends when the others do not make up for that.
    """
    robot = Robot(**changes)
    robot.babble(1200.0)
    assert robot.learner.babbler is not None
    wanted = robot.learner.babbler.inverse(GOAL[:2])
    longest = int(wanted.argmax())
    robot.longest[longest] = wanted[longest] - 0.04
    return robot, np.minimum(wanted, robot.longest)


class TestIdle:
    def test_commands_nothing_before_it_saw_lengths(self) -> None:
        learner = Learner(LearnerSettings(), TASK)
        assert learner.update(PERIOD) is None
        learner.see_tip(PERIOD, GOAL)
        assert learner.update(PERIOD) is None
        assert learner.mode == Learner.IDLE

    def test_holds_the_robot_where_it_is(self) -> None:
        """A robot that is told to stay does not creep after its own sensors."""
        robot = Robot()
        robot.follows = False
        first = robot.step()
        np.testing.assert_array_equal(first, robot.lengths)
        robot.lengths = robot.lengths + 0.01
        np.testing.assert_array_equal(robot.step(10), first)
        assert robot.learner.mode == Learner.IDLE

    def test_knows_when_the_tip_was_seen(self) -> None:
        robot = Robot()
        assert robot.learner.newest_tip is None
        robot.step()
        assert robot.learner.newest_tip == robot.time


class TestBabble:
    def test_goes_home_and_explores_and_holds(self) -> None:
        robot = Robot(settling_time=3.0)
        robot.step(3)
        robot.learner.babble(30.0)
        modes = []
        for _ in range(62):
            robot.step()
            modes.append(robot.learner.mode)
        # 6 periods on the way home, of which the last is seen when it is over.
        assert modes[:6] == 6 * [Learner.HOMING]
        assert modes[6:60] == 54 * [Learner.BABBLING]
        assert modes[60:] == 2 * [Learner.HOLDING]
        np.testing.assert_array_equal(robot.commands[-1], robot.commands[-3])

    @pytest.mark.parametrize(("duration", "periods"), [(0.2, 1), (5.0, 10), (60.0, 120)])
    def test_lasts_exactly_as_long_as_asked(self, duration: float, periods: int) -> None:
        """One command more, which ends it, repeats the last."""
        robot = Robot()
        assert robot.babble(duration) == periods + 1
        np.testing.assert_array_equal(robot.commands[-1], robot.commands[-2])

    def test_exploration_time_adds_up(self) -> None:
        robot = Robot()
        for total in (20.0, 40.0, 60.0):
            robot.babble(20.0)
            assert robot.learner.exploration_time == total

    def test_time_that_taught_nothing_does_not_count(self) -> None:
        """It did not get beyond the way home."""
        robot = Robot()
        robot.babble(2.0)
        assert robot.learner.babbler is None
        assert robot.learner.exploration_time == 0.0
        assert "nothing was explored in 2 s: the way" in robot.learner.failure

    def test_a_robot_whose_tip_is_never_seen_has_not_explored(self) -> None:
        robot = taught(20.0)
        assert not robot.learner.failure
        robot.tracked = False
        robot.babble(20.0)
        assert "the tip must be seen" in robot.learner.failure

    def test_commands_are_one_a_period_and_within_the_limits(self) -> None:
        robot = taught(120.0)
        commands = np.array(robot.commands)
        assert (commands >= TASK.action_low).all()
        assert (commands <= TASK.action_high).all()

    def test_tells_every_sample(self) -> None:
        robot, samples = Robot(), []
        robot.learner.on_sample = lambda *sample: samples.append(sample)
        robot.babble(30.0)
        assert robot.learner.babbler is not None
        assert len(samples) == robot.learner.babbler.samples == 60 - 7

    def test_what_was_learned_can_be_seen_while_it_babbles(self) -> None:
        robot = Robot()
        session = robot.learner.babble(60.0)
        robot.step(50)
        assert robot.learner.session is session
        assert robot.learner.babbler is not None
        assert robot.learner.babbler is session.babbler
        assert robot.learner.exploration_time == session.elapsed == 25.0

    def test_the_seed_draws_the_exploration(self) -> None:
        def commands(seed: int) -> FloatArray:
            robot = Robot(seed=seed)
            robot.babble(20.0)
            return np.array(robot.commands)

        np.testing.assert_array_equal(commands(1), commands(1))
        assert not np.array_equal(commands(1), commands(2))

    def test_restart_forgets(self) -> None:
        robot = taught()
        before = robot.learner.babbler
        robot.learner.babble(20.0, restart=True)
        assert robot.learner.babbler is None
        assert robot.learner.exploration_time == 0.0
        robot.step(20)
        assert robot.learner.babbler is not None
        assert robot.learner.babbler is not before
        assert robot.learner.babbler.samples < 20

    def test_ends_a_movement(self) -> None:
        robot = taught()
        movement = robot.learner.go_to(GOAL)
        robot.learner.babble(20.0)
        assert robot.learner.reach is None
        assert movement.result is None
        robot.step()
        assert robot.learner.mode == Learner.HOMING

    @pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf])
    def test_refuses_durations_that_are_none(self, duration: float) -> None:
        learner = Robot().learner
        assert "duration must be above 0 s" in learner.why_not_babble(duration)
        with pytest.raises(RefusedError, match="duration must be above 0 s"):
            learner.babble(duration)
        assert learner.why_not_babble(1.0) == ""

    def test_a_robot_that_does_not_follow(self) -> None:
        """It ends with the reason, and what was learned before stays."""
        robot = taught()
        babbler, explored = robot.learner.babbler, robot.learner.exploration_time
        robot.follows = False
        robot.lengths = np.full(9, 0.12)
        assert robot.babble(60.0) == 7
        assert "does the pressure controller have a model" in robot.learner.failure
        assert robot.learner.mode == Learner.HOLDING
        assert robot.learner.babbler is babbler
        assert robot.learner.exploration_time - explored == 3.0
        robot.follows = True
        robot.learner.babble(20.0)
        assert robot.learner.failure == ""

    def test_an_absurd_tip_is_passed_over(self) -> None:
        """A tracker that reports 1e200 m for a moment ends neither the node nor the babbling."""
        robot = Robot()
        robot.learner.babble(60.0)
        robot.step(20)
        assert robot.learner.babbler is not None
        samples, last = robot.learner.babbler.samples, robot.commands[-1]
        robot.time += PERIOD
        robot.learner.see_lengths(robot.time, robot.lengths)
        robot.learner.see_tip(robot.time, np.array([1e200, 0.0, 0.0]))
        np.testing.assert_array_equal(robot.learner.update(robot.time), last)
        assert robot.learner.babbler.samples == samples
        robot.step()
        assert robot.learner.babbler.samples == samples + 1

    def test_a_task_that_cannot_be_learned_ends_it_with_the_reason(self) -> None:
        region = dataclasses.replace(TASK.region, polar_steps=1, azimuth_steps=1)
        robot = Robot(task=dataclasses.replace(TASK, region=region))
        robot.babble(60.0)
        assert "at least 2 goals" in robot.learner.failure
        assert robot.learner.mode == Learner.HOLDING

    def test_without_a_tip_nothing_is_told_and_the_robot_waits(self) -> None:
        robot = Robot()
        robot.learner.babble(60.0)
        robot.step(20)
        assert robot.learner.babbler is not None
        samples, last = robot.learner.babbler.samples, robot.commands[-1]
        robot.tracked = False
        np.testing.assert_array_equal(robot.step(10), last)
        assert robot.learner.babbler.samples == samples
        assert robot.learner.mode == Learner.BABBLING
        robot.tracked = True
        assert not np.array_equal(robot.step(2), last)
        assert robot.learner.babbler.samples > samples


class TestResume:
    """A session that was interrupted and goes on equals one that was not."""

    @pytest.mark.parametrize("how", ["its time", "halt", "stop", "a restarted robot", "a goal"])
    @pytest.mark.parametrize("first", [4.0, 17.5, 60.0])
    def test_gives_the_same_actions_bit_for_bit(
        self, tmp_path: Path, first: float, how: str
    ) -> None:
        """Without a body model: that takes note of the rest in which exploration goes on."""
        robot = Robot(task=PLAIN)
        robot.babble(150.0)
        whole = np.array(robot.commands[:-1])

        begun = Robot(task=PLAIN)
        periods = round(2 * first)
        if how == "its time":
            begun.babble(first)
        else:
            begun.learner.babble(150.0)
            begun.step(periods)
            {
                "halt": begun.learner.halt,
                "stop": lambda: begun.learner.stop(True),
                "a restarted robot": begun.learner.robot_restarted,
                "a goal": begun.learner.halt,
            }[how]()
            if how == "a goal":
                begun.end(begun.learner.go_to(GOAL))
        np.testing.assert_array_equal(np.array(begun.commands[:periods]), whole[:periods])
        assert begun.learner.babbler is not None
        path = tmp_path / "checkpoint.npz"
        kept = Checkpoint(begun.learner.babbler, TASK.name, begun.learner.exploration_time)
        save_checkpoint(path, kept, robot="bha")

        stored = load_checkpoint(path, robot="bha", task=TASK.name)
        again = Robot(task=PLAIN, seed=99)  # its own randomness must not matter
        again.learner.use(stored.babbler, stored.exploration_time)
        again.babble(150.0 - first + 3.0)
        continued = np.array(again.commands[6:-1])  # the way to the step it was at
        np.testing.assert_array_equal(continued, whole[periods:])
        assert again.learner.babbler is not None
        assert robot.learner.babbler is not None
        assert again.learner.babbler.samples == robot.learner.babbler.samples
        assert again.learner.exploration_time == 150.0 + 3.0
        goals = TASK.goals()
        np.testing.assert_array_equal(
            again.learner.babbler.inverse(goals), robot.learner.babbler.inverse(goals)
        )

    def test_a_checkpoint_does_not_disturb_the_learner(self, tmp_path: Path) -> None:
        whole, robot = taught(60.0), Robot()
        robot.learner.babble(60.0)
        while robot.learner.session is not None:
            robot.step()
            if robot.learner.babbler is not None:
                kept = Checkpoint(robot.learner.babbler, TASK.name, 0.0)
                save_checkpoint(tmp_path / "checkpoint.npz", kept, robot="bha")
        np.testing.assert_array_equal(robot.commands, whole.commands)


class TestGoals:
    def test_nothing_is_learned(self) -> None:
        robot = Robot()
        for ask in (robot.learner.go_to, robot.learner.follow):
            with pytest.raises(RefusedError, match="nothing is learned yet: babble first"):
                ask(GOAL)
        assert robot.learner.mode == Learner.IDLE

    def test_reaches_and_holds(self) -> None:
        robot = taught(1200.0)
        movement = robot.learner.go_to(GOAL)
        assert robot.learner.mode == Learner.REACHING
        assert robot.learner.reach is movement
        np.testing.assert_array_equal(movement.goal, GOAL[:2])
        robot.end(movement)
        assert movement.result is not None
        assert movement.result.settled
        assert movement.result.error < 0.02
        assert movement.result.duration < 4.0
        assert robot.learner.mode == Learner.HOLDING
        held = robot.commands[-1]
        np.testing.assert_array_equal(robot.step(20), held)

    def test_the_command_is_the_models_answer(self) -> None:
        robot = taught()
        assert robot.learner.babbler is not None
        robot.learner.go_to(GOAL)
        np.testing.assert_array_equal(robot.step(), robot.learner.babbler.inverse(GOAL[:2]))

    def test_sensors_that_shifted_are_made_up_for_from_goal_to_goal(self) -> None:
        """Without any babbling since."""

        def error(lesson: str) -> float:
            robot = Robot(learn_in_use=lesson)
            robot.babble(600.0)
            robot.shift[:3] = [0.005, -0.005, 0.005]
            errors = []
            for goal in TASK.held_out_positions(20, np.random.default_rng(1)):
                robot.end(robot.learner.go_to(goal))
                errors.append(distance(robot.lengths, goal))
            return float(np.mean(errors[10:]))

        assert error("offsets") < 0.7 * error("nothing")

    def test_others_make_up_for_a_bellows_that_ends_short(self) -> None:
        """By lengths alone: the tip is not seen, and nothing is learned."""
        robot, alone = shortened()
        assert robot.learner.babbler is not None
        before = robot.learner.babbler.inverse(TASK.goals())
        robot.tracked = False
        robot.end(robot.learner.go_to(GOAL))
        assert np.abs(robot.commands[-1] - robot.lengths).max() < 0.004
        assert distance(robot.lengths, GOAL) < 0.02
        assert distance(alone, GOAL) > 0.03
        np.testing.assert_array_equal(robot.learner.babbler.inverse(TASK.goals()), before)

    def test_a_robot_that_comes_to_an_end_is_not_at_rest_yet(self) -> None:
        robot, _ = shortened(rest_time=1.0)
        movement = robot.learner.go_to(GOAL)
        robot.end(movement)
        assert movement.result is not None
        assert movement.result.settled
        assert movement.result.error < 0.02

    def test_a_robot_that_is_not_driven_goes_on_where_it_was_sent(self) -> None:
        """A controller that died vents it; when that is back, the command must still be there."""
        robot = taught()
        robot.learner.go_to(GOAL)
        sent = robot.step(3)
        robot.follows, robot.lengths = False, np.full(9, 0.15)
        np.testing.assert_array_equal(robot.step(100), sent)

    def test_a_robot_that_is_not_driven_is_sent_nowhere_else(self) -> None:
        """Not by another model that was loaded meanwhile, nor after a halt."""
        robot, other = taught(), Robot(seed=1)
        other.babble(60.0)
        assert other.learner.babbler is not None
        robot.end(robot.learner.go_to(GOAL))
        held = robot.step()
        robot.learner.use(other.learner.babbler)
        robot.follows, robot.lengths = False, np.full(9, 0.15)
        np.testing.assert_array_equal(robot.step(30), held)
        robot.follows = True
        robot.learner.go_to(-GOAL)
        held = robot.step(2)
        robot.learner.halt()
        robot.follows, robot.lengths = False, np.full(9, 0.15)
        np.testing.assert_array_equal(robot.step(30), held)

    def test_without_a_body_model_it_rests_at_the_end(self) -> None:
        """Nothing makes up for it, and nobody waits for that."""
        robot = Robot(task=PLAIN)
        robot.babble(600.0)
        robot.longest[:] = 0.2
        movement = robot.learner.go_to(GOAL)
        robot.end(movement)
        assert (robot.commands[-1] > 0.21).any()
        assert movement.result is not None
        assert movement.result.settled

    def test_a_new_goal_takes_over(self) -> None:
        robot = taught()
        first = robot.learner.go_to(GOAL)
        robot.step(2)
        second = robot.learner.go_to(-GOAL)
        assert robot.learner.reach is second
        assert robot.learner.goals_set == 2
        robot.end(second)
        assert first.result is None
        assert second.result is not None

    def test_z_is_open_in_two_dimensions(self) -> None:
        robot = taught()
        robot.learner.go_to(np.array([0.1, -0.1, 99.0]))

    @pytest.mark.parametrize(
        ("goal", "reason"),
        [
            ([0.6, 0.0, 0.7], r"0\.600 m off the z axis"),
            ([math.nan, 0.0, 0.7], "finite"),
            ([0.0, math.inf, 0.7], "finite"),
            ([1e300, 0.0, 0.7], "finite and at most"),
        ],
    )
    def test_refuses_goals_out_of_reach(self, goal: list[float], reason: str) -> None:
        robot = taught()
        before = robot.step()
        with pytest.raises(RefusedError, match=f"the goal is refused: .*{reason}"):
            robot.learner.go_to(np.array(goal))
        assert robot.learner.mode == Learner.HOLDING
        np.testing.assert_array_equal(robot.step(5), before)

    @pytest.mark.parametrize("value", [-1.0, math.nan, math.inf])
    @pytest.mark.parametrize("name", ["tolerance", "timeout"])
    def test_refuses_limits_that_are_none(self, name: str, value: float) -> None:
        robot = taught()
        before = robot.step()
        with pytest.raises(RefusedError, match=f"{name} must be 0 or above"):
            robot.learner.go_to(GOAL, **{name: value})
        np.testing.assert_array_equal(robot.step(), before)

    def test_refuses_everything_while_it_babbles(self) -> None:
        """And goes on as if nothing had been asked."""
        whole, robot = taught(60.0), Robot()
        robot.learner.babble(60.0)
        while robot.learner.session is not None:
            robot.step()
            if robot.learner.session is None:
                break
            for ask in (
                lambda: robot.learner.go_to(GOAL),
                lambda: robot.learner.follow(GOAL),
                lambda: robot.learner.babble(10.0),
                lambda: robot.learner.babble(10.0, restart=True),
                lambda: robot.learner.use(whole.learner.babbler, 0.0),  # type: ignore[arg-type]
            ):
                with pytest.raises(RefusedError, match="it babbles and accepts nothing else"):
                    ask()
            assert "babbles" in robot.learner.why_not_babble(10.0)
        np.testing.assert_array_equal(robot.commands, whole.commands)

    def test_halt_holds_where_it_was_commanded(self) -> None:
        robot = taught()
        movement = robot.learner.go_to(GOAL)
        command = robot.step(2)
        robot.learner.halt()
        assert robot.learner.reach is None
        assert movement.result is None
        assert robot.learner.mode == Learner.HOLDING
        np.testing.assert_array_equal(robot.step(10), command)

    def test_without_a_tip_it_runs_out_of_time(self) -> None:
        robot = taught()
        robot.tracked = False
        movement = robot.learner.go_to(GOAL)
        robot.end(movement)
        assert movement.result is not None
        assert movement.result.tip is None
        assert movement.result.duration == robot.learner.settings.reach_timeout


class TestFollow:
    def test_commands_the_models_answer_to_every_target(self) -> None:
        robot = taught()
        assert robot.learner.babbler is not None
        for step in range(20):
            target = GOAL + 0.002 * step
            robot.learner.follow(target)
            expected = robot.learner.babbler.inverse(target[:2])
            np.testing.assert_array_equal(robot.step(), expected)
            assert robot.learner.mode == Learner.HOLDING

    def test_ends_a_movement(self) -> None:
        robot = taught()
        movement = robot.learner.go_to(GOAL)
        robot.learner.follow(-GOAL)
        assert robot.learner.reach is None
        assert movement.result is None

    def test_ends_that_were_found_on_the_way_count_for_targets_near_the_goal(self) -> None:
        robot, _ = shortened()
        robot.end(robot.learner.go_to(GOAL))
        for target in (GOAL, GOAL + np.array([0.01, 0.0, 0.0])):
            robot.learner.follow(target)
            assert (robot.step() <= robot.longest + 1e-9).all()
        robot.learner.follow(-GOAL)
        robot.step(10)
        robot.learner.follow(GOAL)
        assert (robot.step() > robot.longest + 0.01).any()

    def test_takes_targets_a_little_outside(self) -> None:
        """So that feedback reaches the edge: corrections may be 15 cm."""
        robot = taught()
        edge = 0.78 * np.sin(np.radians(36.0))
        with pytest.raises(RefusedError, match="off the z axis"):
            robot.learner.go_to(np.array([edge + 0.15, 0.0, 0.7]))
        robot.learner.follow(np.array([edge + 0.15, 0.0, 0.7]))

    @pytest.mark.parametrize("target", [[1e200, 0.0, 0.7], [math.nan, 0.0, 0.7], [9.0, 0.0, 0.7]])
    def test_refuses_targets_far_outside(self, target: list[float]) -> None:
        """With an error that the node knows, whatever the number is."""
        robot = taught()
        movement = robot.learner.go_to(GOAL)
        before = robot.step()
        with pytest.raises(RefusedError, match="the target is refused"):
            robot.learner.follow(np.array(target))
        assert robot.learner.reach is movement
        np.testing.assert_array_equal(robot.step(), before)


class TestStop:
    def test_the_command_follows_the_lengths(self) -> None:
        """So that nothing moves when the stop is over."""
        robot = taught()
        robot.learner.go_to(GOAL)
        robot.step(2)
        robot.learner.stop(True)
        robot.follows = False
        for _ in range(10):
            robot.lengths = robot.lengths - 0.005
            np.testing.assert_array_equal(robot.step(), robot.lengths)
            assert robot.learner.mode == Learner.STOPPED
        robot.learner.stop(False)
        assert robot.learner.mode == Learner.IDLE
        last = robot.lengths
        robot.lengths = robot.lengths + 0.01
        np.testing.assert_array_equal(robot.step(10), last)

    def test_a_stop_that_is_over_at_once_forgets_the_goal_too(self) -> None:
        robot = taught()
        robot.learner.go_to(GOAL)
        robot.step()
        robot.follows = False
        robot.lengths = robot.lengths + 0.01
        robot.learner.stop(True)
        robot.learner.stop(False)
        np.testing.assert_array_equal(robot.step(), robot.lengths)

    def test_ends_babbling_and_keeps_what_was_learned(self) -> None:
        robot = Robot()
        robot.learner.babble(60.0)
        robot.step(30)
        babbler = robot.learner.babbler
        robot.learner.stop(True)
        assert robot.learner.session is None
        assert babbler is not None
        assert robot.learner.babbler is babbler

    def test_refuses_everything(self) -> None:
        robot = taught()
        babbler = robot.learner.babbler
        assert babbler is not None
        robot.learner.stop(True)
        robot.step()
        for ask in (
            lambda: robot.learner.go_to(GOAL),
            lambda: robot.learner.follow(GOAL),
            lambda: robot.learner.babble(10.0),
            lambda: robot.learner.use(babbler),
        ):
            with pytest.raises(RefusedError, match="emergency stop is active: reset it first"):
                ask()
        robot.learner.stop(False)
        robot.learner.go_to(GOAL)


class TestRestartedRobot:
    @pytest.mark.parametrize("babbling", [False, True])
    def test_holds_where_the_new_robot_is(self, babbling: bool) -> None:
        robot = taught()
        if babbling:
            robot.learner.babble(60.0)
        else:
            robot.learner.go_to(GOAL)
        robot.step(20)
        babbler = robot.learner.babbler
        robot.learner.robot_restarted()
        assert robot.learner.session is None
        assert robot.learner.reach is None
        assert robot.learner.mode == Learner.IDLE
        assert robot.learner.babbler is babbler
        robot.time, robot.lengths = 0, np.full(9, 0.15)
        np.testing.assert_array_equal(robot.step(5), np.full(9, 0.15))

    def test_what_was_seen_of_the_old_one_does_not_count(self) -> None:
        robot = Robot()
        robot.step(5)
        robot.learner.robot_restarted()
        assert robot.learner.newest_tip is None
        assert robot.learner.update(robot.time) is None

    def test_does_not_end_the_emergency_stop(self) -> None:
        robot = Robot()
        robot.learner.stop(True)
        robot.learner.robot_restarted()
        assert robot.learner.mode == Learner.STOPPED


class TestUse:
    def test_goes_on_with_what_another_has_learned(self) -> None:
        other, robot = taught(), Robot()
        assert other.learner.babbler is not None
        robot.learner.use(other.learner.babbler, 60.0)
        assert robot.learner.exploration_time == 60.0
        robot.learner.go_to(GOAL)
        np.testing.assert_array_equal(robot.step(), other.learner.babbler.inverse(GOAL[:2]))

    def test_refuses_a_model_of_another_size(self) -> None:
        robot, babbler = Robot(task=load_task(CONFIG / "task_3d.yaml")), taught().learner.babbler
        assert babbler is not None
        with pytest.raises(RefusedError, match="has 2 coordinates, but task 3d has 3"):
            robot.learner.use(babbler)
        assert robot.learner.babbler is None

    def test_refuses_a_model_of_a_robot_with_other_joints(self) -> None:
        """A planar arm's checkpoint has two coordinates as well."""
        arm = GoalBabbler(
            GoalBabblerConfig(),
            [[0.5, 0.0], [0.5, 0.1]],
            np.zeros(4),
            [0.7, 0.0],
            np.full(4, -1.0),
            np.full(4, 1.0),
            np.random.default_rng(0),
        )
        robot = Robot()
        with pytest.raises(RefusedError, match="has 4 lengths, but this robot has 9"):
            robot.learner.use(arm)
        assert robot.learner.babbler is None
