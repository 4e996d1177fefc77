"""What a robot lets through: range, watchdog, emergency stop."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from bha_common.command_gate import CommandGate, SafetySettings

PERIOD = 0.02
SOME = np.linspace(1e4, 9e4, 9)


def gate(**settings: Any) -> CommandGate:
    return CommandGate(SafetySettings(**settings))


def test_applies_nothing_before_the_first_command() -> None:
    robot = gate()
    np.testing.assert_array_equal(robot.pressures(0.0, PERIOD), np.zeros(9))
    assert robot.state == CommandGate.SILENT
    assert not robot.stopped


def test_passes_a_command_on() -> None:
    robot = gate()
    robot.offer(1.0, SOME)
    np.testing.assert_array_equal(robot.pressures(1.0, PERIOD), SOME)
    assert robot.state == CommandGate.RUNNING


@given(hnp.arrays(np.float64, 9, elements=st.floats(-1e9, 1e9)))
def test_clips_to_the_range(pressures: np.ndarray) -> None:
    robot = gate(max_pressure=1e5)
    robot.offer(1.0, pressures)
    np.testing.assert_array_equal(robot.pressures(1.0, PERIOD), np.clip(pressures, 0.0, 1e5))


def test_does_not_change_what_it_is_given() -> None:
    pressures = np.full(9, 1e9)
    gate().offer(1.0, pressures)
    assert (pressures == 1e9).all()


def test_goes_on_with_the_last_command_until_the_timeout() -> None:
    """The timeout counts from the command's own time, with half a period of slack."""
    robot = gate(command_timeout=1.0)
    robot.offer(5.0, SOME)
    for tick in range(51):  # 5.00 to 6.00 s
        np.testing.assert_array_equal(robot.pressures(5.0 + tick * PERIOD, PERIOD), SOME)
    assert (robot.pressures(6.02, PERIOD) < SOME).all()
    assert robot.state == CommandGate.SILENT


def test_vents_at_a_limited_rate_to_zero() -> None:
    robot = gate(command_timeout=0.1, vent_rate=4e4)
    robot.offer(1.0, SOME)
    before = robot.pressures(1.0, PERIOD)
    for tick in range(1, 200):
        after = robot.pressures(1.2 + tick * PERIOD, PERIOD)
        np.testing.assert_allclose(after, np.maximum(before - 4e4 * PERIOD, 0.0))
        before = after
    np.testing.assert_array_equal(before, np.zeros(9))


def test_holds_where_that_is_the_safe_state() -> None:
    robot = gate(command_timeout=0.1, safe_state="hold")
    robot.offer(1.0, SOME)
    robot.pressures(1.0, PERIOD)
    np.testing.assert_array_equal(robot.pressures(9.0, PERIOD), SOME)
    robot.stop()
    np.testing.assert_array_equal(robot.pressures(9.02, PERIOD), SOME)


def test_holds_what_was_applied_and_not_what_was_only_commanded() -> None:
    """A command that was never applied must not begin to work in the safe state."""
    robot = gate(safe_state="hold")
    robot.offer(1.0, SOME)
    robot.stop()
    np.testing.assert_array_equal(robot.pressures(1.0, PERIOD), np.zeros(9))


def test_recovers_from_silence_with_the_next_command() -> None:
    robot = gate(command_timeout=0.1)
    robot.offer(1.0, SOME)
    robot.pressures(3.0, PERIOD)
    robot.offer(3.02, SOME / 2)
    np.testing.assert_array_equal(robot.pressures(3.02, PERIOD), SOME / 2)


def test_the_emergency_stop_is_latched() -> None:
    robot = gate()
    robot.offer(1.0, SOME)
    robot.pressures(1.0, PERIOD)
    robot.stop()
    previous = SOME
    for tick in range(1, 150):
        time = 1.0 + tick * PERIOD
        robot.offer(time, SOME)
        applied = robot.pressures(time, PERIOD)
        assert (applied <= previous).all()
        previous = applied
        assert robot.stopped
        assert robot.state == CommandGate.STOPPED
    np.testing.assert_array_equal(previous, np.zeros(9))


def test_a_reset_brings_no_old_command_back() -> None:
    """Neither the one in force before the stop, nor one that was sent while it lasted."""
    robot = gate()
    robot.offer(1.0, SOME)
    robot.stop()
    robot.offer(1.5, SOME)
    robot.reset_stop(2.0)
    assert not robot.stopped
    assert robot.state == CommandGate.SILENT
    for time in (1.0, 1.5, 1.98, 2.0):  # still under way when the stop was reset
        robot.offer(time, SOME)
    np.testing.assert_array_equal(robot.pressures(2.0, PERIOD), np.zeros(9))
    robot.offer(2.02, SOME)
    np.testing.assert_array_equal(robot.pressures(2.02, PERIOD), SOME)


def test_a_dropped_command_does_not_come_back() -> None:
    robot = gate()
    robot.offer(1.0, SOME)
    robot.drop(1.0)
    robot.offer(1.0, SOME)
    np.testing.assert_array_equal(robot.pressures(1.0, PERIOD), np.zeros(9))
    robot.offer(1.02, SOME)
    np.testing.assert_array_equal(robot.pressures(1.02, PERIOD), SOME)


@pytest.mark.parametrize("safe_state", ["vent", "hold"])
def test_a_fresh_robot_is_vented_at_once(safe_state: str) -> None:
    robot = gate(safe_state=safe_state)
    robot.offer(1.0, SOME)
    robot.pressures(1.0, PERIOD)
    robot.begin_anew(1.0)
    robot.offer(1.0, SOME)  # given to the robot before
    assert not robot.pressures(1.02, PERIOD).any()
    robot.offer(1.04, SOME)
    np.testing.assert_array_equal(robot.pressures(1.04, PERIOD), SOME)


def test_dropping_does_not_end_the_stop() -> None:
    robot = gate()
    robot.stop()
    robot.drop(1.0)
    robot.offer(2.0, SOME)
    np.testing.assert_array_equal(robot.pressures(2.0, PERIOD), np.zeros(9))


@pytest.mark.parametrize(
    "wrong",
    [
        {"command_timeout": 0.0},
        {"safe_state": "fall"},
        {"vent_rate": 0.0},
        {"max_pressure": 3e5},
        {"max_pressure": float("nan")},
    ],
)
def test_settings_out_of_range(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        SafetySettings(**wrong)


class AnyOrder(RuleBasedStateMachine):
    """Whatever comes in whatever order, what is applied stays in range and never rises unasked."""

    def __init__(self) -> None:
        super().__init__()
        self.gate = gate(command_timeout=0.1, max_pressure=1e5)
        self.time = 1.0
        self.applied = np.zeros(9)
        self.allowed = False  # whether a command is known that may raise the pressures
        self.reset_at = -1.0
        self.offered_at = -1.0

    @rule(pressure=st.floats(-1e6, 1e6), age=st.sampled_from([0.0, 0.02, 0.06]))
    def offer(self, pressure: float, age: float) -> None:
        time = self.time - age
        self.gate.offer(time, np.full(9, pressure))
        if not self.gate.stopped and time > self.reset_at:
            self.allowed, self.offered_at = True, time

    @rule()
    def stop(self) -> None:
        self.gate.stop()
        self.allowed = False

    @rule()
    def reset(self) -> None:
        self.gate.reset_stop(self.time)
        self.allowed, self.reset_at = False, self.time

    @rule(ticks=st.integers(1, 12))
    def advance(self, ticks: int) -> None:
        for _ in range(ticks):
            self.time += PERIOD
            if self.time - self.offered_at > 0.1 + PERIOD:
                self.allowed = False
            before, self.applied = self.applied, self.gate.pressures(self.time, PERIOD).copy()
            if not self.allowed:
                assert (self.applied <= before).all()

    @invariant()
    def in_range(self) -> None:
        assert ((self.applied >= 0.0) & (self.applied <= 1e5)).all()


TestAnyOrder = AnyOrder.TestCase
TestAnyOrder.settings = settings(max_examples=40, stateful_step_count=20, deadline=None)


def test_venting_begins_at_what_was_really_applied() -> None:
    """A driver that limits rates is behind its command when the command ends."""
    robot = gate(vent_rate=1e4)
    robot.offer(1.0, np.full(9, 1e5))
    robot.pressures(1.0, PERIOD)
    robot.applied(np.full(9, 3e4))
    robot.stop()
    np.testing.assert_allclose(robot.pressures(1.02, PERIOD), np.full(9, 3e4 - 1e4 * PERIOD))
