from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from bha_driver.robot_time import RobotTime, Ticks

PERIOD = 20_000_000


def test_it_begins_at_the_systems_time_and_never_steps() -> None:
    system, steady = [1_000_000], [50]
    time = RobotTime(lambda: system[0], lambda: steady[0])
    assert time.now() == 1_000_000
    system[0] = 5  # the system's clock is set back
    steady[0] += 700
    assert time.now() == 1_000_700


@given(st.lists(st.integers(0, 10**8), min_size=1, max_size=50))
def test_ticks_are_multiples_and_rise(waits: list[int]) -> None:
    ticks, now, taken = Ticks(PERIOD), 10**18, []
    for wait in waits:
        now += wait
        if ticks.wait(now) <= 0:
            tick = ticks.take(now)
            assert 0 <= now - tick < PERIOD
            taken.append(tick)
    assert all(tick % PERIOD == 0 for tick in taken)
    assert all(b - a >= PERIOD for a, b in pairwise(taken))
    assert ticks.missed == (taken[-1] - taken[0]) // PERIOD - (len(taken) - 1)
