"""Which stamps to believe."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_common.stamps import StampError, StreamClock, check_command_stamp

SECOND = 1_000_000_000
PERIOD = 20_000_000


class Restarts:
    """Counts restarts and notes what the clock said at each."""

    def __init__(self, max_gap: float = math.inf) -> None:
        self.clock = StreamClock(on_restart=self.note, max_gap=max_gap)
        self.seen: list[int | None] = []

    def note(self) -> None:
        self.seen.append(self.clock.now)

    def offer(self, *stamps: int) -> list[bool]:
        """Offer stamps and tell which were taken."""
        taken = []
        for stamp in stamps:
            try:
                self.clock.advance(stamp)
                taken.append(True)
            except StampError:
                taken.append(False)
        return taken


def test_knows_no_time_before_the_first_state() -> None:
    assert StreamClock().now is None


@given(st.lists(st.integers(1, 2**62), min_size=1, unique=True))
def test_takes_every_rising_stream(stamps: list[int]) -> None:
    robot = Restarts()
    assert all(robot.offer(*sorted(stamps)))
    assert robot.clock.now == max(stamps)
    assert robot.seen == []


def test_refuses_what_is_not_newer() -> None:
    clock = StreamClock()
    clock.advance(5 * SECOND)
    for stamp in (5 * SECOND, 5 * SECOND - 1, PERIOD):
        with pytest.raises(StampError, match=r"not newer than the last one, 5\.000 s"):
            clock.advance(stamp)
        assert clock.now == 5 * SECOND


@pytest.mark.parametrize("stamp", [0, -1, -SECOND])
def test_refuses_a_state_without_a_stamp(stamp: int) -> None:
    """Time begins above 0; a 0 is a stamp that nobody has set."""
    clock = StreamClock()
    with pytest.raises(StampError, match="no stamp"):
        clock.advance(stamp)
    assert clock.now is None


def test_unset_stamps_never_look_like_a_restart() -> None:
    robot = Restarts()
    assert robot.offer(SECOND, 0, 0, 0, -3, -2, -1) == [True] + 6 * [False]
    assert robot.seen == []


def test_a_robot_that_began_anew_is_believed_at_its_third_state() -> None:
    robot = Restarts()
    robot.offer(100 * SECOND)
    assert robot.offer(PERIOD, 2 * PERIOD, 3 * PERIOD) == [False, False, True]
    assert robot.clock.now == 3 * PERIOD
    assert robot.seen == [100 * SECOND]  # told before the new time is taken over
    assert robot.offer(4 * PERIOD) == [True]


def test_a_repeated_state_is_never_a_restart() -> None:
    robot = Restarts()
    assert robot.offer(*[SECOND] * 50) == [True] + 49 * [False]
    assert robot.seen == []


def test_falling_stamps_are_never_a_restart() -> None:
    robot = Restarts()
    assert robot.offer(*range(SECOND, 0, -PERIOD)) == [True] + 49 * [False]
    assert robot.seen == []


def test_single_stragglers_among_new_states_are_never_a_restart() -> None:
    """Doubts end with the next state that is newer."""
    robot = Restarts()
    for step in range(1, 50):
        assert robot.offer(SECOND + step * PERIOD, step * PERIOD) == [True, False]
    assert robot.seen == []


def test_can_begin_anew_again_and_again() -> None:
    robot = Restarts()
    for _ in range(4):
        robot.offer(*range(PERIOD, 10 * PERIOD, PERIOD))
    assert robot.seen == 3 * [9 * PERIOD]


def test_a_restart_without_a_listener() -> None:
    clock = StreamClock()
    for stamp in (10, 1, 2):
        try:
            clock.advance(stamp)
        except StampError:
            continue
    clock.advance(3)
    assert clock.now == 3


def test_a_single_leap_ahead_is_refused() -> None:
    """A wrong stamp far ahead must not make all right ones look old."""
    robot = Restarts(max_gap=1.0)
    assert robot.offer(SECOND, 10**6 * SECOND, SECOND + PERIOD) == [True, False, True]
    with pytest.raises(StampError, match=r"stamp 9\.000 s leaps ahead of the last one, 1\.020 s"):
        robot.clock.advance(9 * SECOND)
    assert robot.seen == []


def test_a_gap_as_long_as_allowed() -> None:
    robot = Restarts(max_gap=1.0)
    assert robot.offer(SECOND, 2 * SECOND, 3 * SECOND + 1) == [True, True, False]


def test_a_stream_that_goes_on_after_a_gap_is_believed_and_no_restart() -> None:
    robot = Restarts(max_gap=1.0)
    later = 100 * SECOND
    assert robot.offer(SECOND, later, later + PERIOD, later + 2 * PERIOD) == [
        True,
        False,
        False,
        True,
    ]
    assert robot.seen == []
    assert robot.clock.now == later + 2 * PERIOD


def test_states_that_leap_from_one_another_are_never_believed() -> None:
    robot = Restarts(max_gap=1.0)
    leaps = range(SECOND, 100 * SECOND, 5 * SECOND)
    assert robot.offer(*leaps) == [True] + [False] * (len(leaps) - 1)
    back = range(100 * SECOND, SECOND, -5 * SECOND)
    assert not any(robot.offer(*back))
    assert robot.seen == []


@given(st.lists(st.integers(-5, 30), max_size=60))
def test_time_never_falls_but_at_a_restart(stamps: list[int]) -> None:
    robot = Restarts()
    for stamp in stamps:
        before, restarts = robot.clock.now, len(robot.seen)
        (taken,) = robot.offer(stamp)
        now = robot.clock.now
        assert now == (stamp if taken else before)
        restarted = taken and before is not None and stamp <= before
        assert len(robot.seen) == restarts + restarted


class TestCommandStamps:
    """Commands are for now."""

    def test_none(self) -> None:
        with pytest.raises(StampError, match=r"no stamp: set header\.stamp"):
            check_command_stamp(0, SECOND, 1.0)

    def test_no_time_yet(self) -> None:
        with pytest.raises(StampError, match="time is not known yet"):
            check_command_stamp(SECOND, None, 1.0)

    @pytest.mark.parametrize("age", [-1.0, -0.5, 0.0, 0.5, 1.0])
    def test_near_enough(self, age: float) -> None:
        check_command_stamp(10 * SECOND - round(age * SECOND), 10 * SECOND, 1.0)

    @pytest.mark.parametrize("age", [-1e9, -1.001, 1.001, 9.0])
    def test_too_old_or_too_far_ahead(self, age: float) -> None:
        with pytest.raises(StampError, match=r"is -?\d+\.\d{3} s old; at most 1\.000 s"):
            check_command_stamp(10 * SECOND - round(age * SECOND), 10 * SECOND, 1.0)

    def test_before_time_began(self) -> None:
        """Seconds of a stamp are signed."""
        with pytest.raises(StampError, match="old"):
            check_command_stamp(-5 * SECOND, SECOND, 1.0)
