"""One read and one write a period, whatever the answer does."""

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from bha_driver.cycle_schedule import CycleSchedule

MS = 1_000_000


def test_a_cycle_without_an_answer_writes_halfway() -> None:
    schedule = CycleSchedule(20 * MS)
    assert schedule.read_due(1003 * MS)
    assert schedule.begin(1003 * MS) == 1000 * MS
    assert not schedule.read_due(1003 * MS)
    assert schedule.wait(1003 * MS) == 7 * MS
    assert not schedule.write_due(1009 * MS)
    assert schedule.write_due(1010 * MS)
    schedule.written()
    assert not schedule.write_owed
    assert schedule.wait(1011 * MS) == 9 * MS
    assert schedule.read_due(1020 * MS)


def test_a_cycle_that_was_answered_writes_no_second_time() -> None:
    schedule = CycleSchedule(20 * MS)
    schedule.begin(1000 * MS)
    schedule.written()
    assert not schedule.write_due(1019 * MS)


def test_missed_cycles_are_counted_and_not_made_up_for() -> None:
    schedule = CycleSchedule(20 * MS)
    schedule.begin(1000 * MS)
    assert schedule.begin(1095 * MS) == 1080 * MS
    assert schedule.missed == 3
    assert not schedule.read_due(1095 * MS)


@given(st.lists(st.integers(1, 30 * MS), min_size=1, max_size=200), st.sets(st.integers(0, 50)))
def test_no_cycle_reads_or_writes_twice(steps: list[int], answered: set[int]) -> None:
    """The order in which the driver asks, at any times."""
    schedule, now, done = CycleSchedule(20 * MS), 10**18, []
    for step in steps:
        now += step
        if schedule.write_due(now):
            schedule.written()
            done.append("write")
        if schedule.read_due(now):
            if schedule.write_owed:
                schedule.written()
                done.append("write")
            tick = schedule.begin(now)
            done.append("read")
            assert tick % (20 * MS) == 0
            assert 0 <= now - tick < 20 * MS
            if len(done) in answered:
                schedule.written()
                done.append("write")
        assert schedule.wait(now) <= 20 * MS
    assert all(first != second for first, second in pairwise(done))
