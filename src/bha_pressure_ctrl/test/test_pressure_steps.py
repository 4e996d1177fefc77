"""Steps of all pressures together."""

import numpy as np
import pytest

from bha_pressure_ctrl.pressure_steps import PressureSteps

PERIOD, RATE, TOP = 0.02, 6e4, 1e5


def run(count: int) -> tuple[PressureSteps, np.ndarray]:
    """Run to the end with lengths that number the ticks; return all pressures."""
    steps = PressureSteps(count, max_pressure=TOP, start=np.zeros(9), rate=RATE, period=PERIOD)
    pressures = []
    while not steps.done:
        pressures.append(steps.update(np.full(9, float(len(pressures)))))
        assert len(pressures) < 10_000
    return steps, np.array(pressures)


def test_the_way_to_them_is_slow_and_they_are_not() -> None:
    _, pressures = run(4)
    assert (pressures == pressures[:, :1]).all()
    changes = np.abs(np.diff(pressures[:, 0]))
    jumps = changes[changes > RATE * PERIOD * 1.001]
    np.testing.assert_allclose(jumps, 0.3 * TOP)
    assert len(jumps) == 4


def test_they_go_up_first_and_stay_in_the_middle_of_the_range() -> None:
    _, pressures = run(3)
    begin = np.flatnonzero(pressures[:, 0] == 0.35 * TOP)[0] + 1  # the first is still the way
    levels = pressures[begin:, 0][:: round(2.0 / PERIOD)]
    np.testing.assert_allclose(levels, TOP * np.array([0.35, 0.65, 0.35, 0.65]))


def test_lengths_are_told_with_the_pressures_asked_for_at_that_time() -> None:
    steps, pressures = run(2)
    lengths, asked = steps.seen()
    assert lengths.shape == asked.shape == (3, round(2.0 / PERIOD), 9)
    ticks = lengths[:, :, 0].astype(int)
    np.testing.assert_array_equal(np.diff(ticks.ravel()), 1)
    np.testing.assert_array_equal(asked, pressures[ticks])


def test_what_is_not_over_is_not_told() -> None:
    steps = PressureSteps(2, max_pressure=TOP, start=np.full(9, 0.35 * TOP), rate=RATE, period=0.02)
    assert steps.seen()[0].shape == (0, 100, 9)
    for _ in range(150):
        steps.update(np.zeros(9))
    assert steps.seen()[0].shape == (1, 100, 9)
    assert not steps.done


@pytest.mark.parametrize("count", [0, 2])
def test_when_they_are_over_the_last_pressures_stay(count: int) -> None:
    steps, pressures = run(count)
    last = pressures[-1] if count else np.zeros(9)
    for _ in range(10):
        if count:
            np.testing.assert_array_equal(steps.update(np.zeros(9)), last)
    assert steps.done
