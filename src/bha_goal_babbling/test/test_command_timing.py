"""One command a period, with the tip of that period or without it."""

from hypothesis import given
from hypothesis import strategies as st

from bha_goal_babbling.command_timing import TIP_LOST, CommandTiming

SECOND = 1_000_000_000
PERIOD, PATIENCE = SECOND // 2, SECOND // 4


def timing() -> CommandTiming:
    return CommandTiming(period=0.5, tip_timeout=0.25)


def due_at(stamp: int) -> CommandTiming:
    """Return a timing with a command that is due since a stamp."""
    made = timing()
    made.advance(stamp - 1, stamp)
    return made


@given(steps=st.lists(st.integers(1, 3 * PERIOD), min_size=1, max_size=50))
def test_one_command_a_period_whatever_the_stamps(steps: list[int]) -> None:
    """With tips that come at once: one for every stretch of states that reaches a new period."""
    made, now, commands = timing(), 0, []
    for step in steps:
        before, now = now or None, now + step
        made.advance(before, now)
        command = made.take(now, tip=now)
        if command is not None:
            commands.append(command)
        assert made.take(now, tip=now) is None
        if before is not None:
            assert (command == now) == (now // PERIOD > before // PERIOD)
    periods = [command // PERIOD for command in commands]
    assert periods == sorted(set(periods))


@given(late=st.integers(1, TIP_LOST), waited=st.integers(0, 2 * PATIENCE))
def test_it_waits_for_the_tip_of_the_period(late: int, waited: int) -> None:
    made, due = due_at(4 * PERIOD), 4 * PERIOD
    given_up = made.take(due + waited, tip=due - late)
    assert given_up == (due if waited >= PATIENCE else None)
    if given_up is None:
        assert made.take(due + waited, tip=due) == due


def test_tips_that_come_no_more_are_not_waited_for() -> None:
    due = 4 * PERIOD
    assert due_at(due).take(due, tip=None) == due
    assert due_at(due).take(due, tip=due - TIP_LOST - 1) == due


def test_a_robot_that_starts_anew_is_given_no_old_command() -> None:
    made = due_at(4 * PERIOD)
    made.forget()
    assert made.take(4 * PERIOD, tip=4 * PERIOD) is None
    made.advance(None, 1)
    assert made.take(1, tip=1) is None
    made.advance(1, PERIOD)
    assert made.take(PERIOD, tip=PERIOD) == PERIOD
