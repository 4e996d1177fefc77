"""Range and rate of what is written, for any wish and any time."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_driver.scaling import Scaling
from bha_driver.set_points import SetPoints
from bha_driver.terminal_file import example_path, load_terminal

LAB = load_terminal(example_path("cpx_e"))
SCALING = Scaling(LAB)
PERIOD = 0.02
WISHES = st.lists(st.floats(-1e12, 1e12), min_size=9, max_size=9)
STEPS = st.lists(st.tuples(st.floats(-10.0, 10.0), WISHES), max_size=40)


@settings(max_examples=200, deadline=None)
@given(STEPS)
def test_range_and_rate_hold_whatever_is_wanted_and_whatever_the_clock_does(steps: list) -> None:
    set_points, time, before = SetPoints(LAB, PERIOD), 1000.0, SCALING.vented
    most = LAB.limits.pressure_rate * PERIOD + SCALING.count_worth * 1.001
    for dt, wanted in steps:
        time += dt
        words = set_points.move(np.array(wanted), set_points.elapsed(time))
        assert words.min() >= 0
        pressures = SCALING.commanded(words)
        assert (pressures <= LAB.limits.pressure).all()
        change = np.abs(pressures - SCALING.commanded(before))
        assert (change <= most).all()
        before = words


def test_time_before_the_begin_does_not_count() -> None:
    set_points = SetPoints(LAB, PERIOD)
    set_points.elapsed(1000.0)
    set_points.begin()
    assert set_points.elapsed(1001.0) == 0.0
    assert set_points.elapsed(1001.01) == 1001.01 - 1001.0


def test_it_presses_until_nothing_is_confirmed() -> None:
    set_points = SetPoints(LAB, PERIOD)
    set_points.move(np.full(9, 1e5), PERIOD)
    assert set_points.pressing, "unconfirmed, but it may have been taken"
    set_points.move(np.zeros(9), PERIOD)
    assert set_points.pressing, "that it has vented is not confirmed"
    set_points.confirmed()
    assert not set_points.pressing
