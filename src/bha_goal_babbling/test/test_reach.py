"""When a movement to a goal is over."""

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.reach import Reach
from bha_goal_babbling.task import load_task

CONFIG = Path(__file__).parents[1] / "config"
FLAT, SPACE = (load_task(CONFIG / f"task_{name}.yaml") for name in ("2d", "3d"))
SETTINGS = LearnerSettings(
    command_period=0.5, rest_time=3.0, rest_distance=0.001, reach_timeout=20.0
)
GOAL = np.array([0.1, 0.2])
THERE = np.array([0.1, 0.2, 0.7])


def off(x: float, y: float, z: float) -> FloatArray:
    """Return a tip that far from where it should be."""
    tip: FloatArray = THERE + np.array([x, y, z])
    return tip


def reach(tolerance: float = 0.0, timeout: float = 0.0) -> Reach:
    return Reach(FLAT, SETTINGS, GOAL, tolerance, timeout)


def settle_time(movement: Reach, tips: Iterable[FloatArray | None]) -> float:
    """Show tips, one a command period, until the movement is over; return its duration [s]."""
    for tip in tips:
        movement.update(tip)
        if movement.result is not None:
            return movement.result.duration
    raise AssertionError("the movement did not end")


def test_before_the_first_tip() -> None:
    movement = reach()
    assert math.isnan(movement.error)
    assert movement.tip is None
    assert movement.elapsed == 0.0
    assert movement.result is None


def test_ends_when_the_tip_has_rested_for_the_rest_time() -> None:
    movement = reach()
    for period in range(6):
        movement.update(THERE)
        assert movement.result is None
        assert movement.elapsed == 0.5 * (period + 1)
    movement.update(THERE)
    assert movement.result is not None
    assert movement.result.settled
    assert movement.result.duration == 3.0
    assert movement.result.error == pytest.approx(0.0)
    np.testing.assert_array_equal(movement.result.tip, THERE)


def test_rest_begins_when_the_tip_has_come_to_it() -> None:
    """A slow approach counts as motion: 2.4 mm in 3 s are more than 1 mm."""
    approach = [off(0.0, 0.0, 0.0004 * (20 - k)) for k in range(20)]
    assert settle_time(reach(), approach + 10 * [THERE]) == 0.5 * (20 - 2 + 6)


def test_noise_below_the_rest_distance_is_rest() -> None:
    rng = np.random.default_rng(0)
    tips = (THERE + 0.0002 * rng.uniform(-1.0, 1.0, 3) for _ in range(100))
    assert settle_time(reach(), tips) == 3.0


def test_a_swinging_tip_runs_out_of_time() -> None:
    """Also where it is back at the same place after each period of the swing."""
    movement = reach()
    tips = (off(0.01 * (k % 2), 0.0, 0.0) for k in range(100))
    assert settle_time(movement, tips) == 20.0
    assert movement.result is not None
    assert not movement.result.settled


def test_with_a_tolerance_it_must_rest_within_it() -> None:
    movement = reach(tolerance=0.005)
    away = off(0.01, 0.0, 0.0)
    assert settle_time(movement, 12 * [away] + 20 * [THERE]) == pytest.approx(0.5 * (12 + 6))
    assert movement.result is not None
    assert movement.result.settled


def test_resting_elsewhere_is_not_within_the_tolerance() -> None:
    movement = reach(tolerance=0.005)
    assert settle_time(movement, 100 * [off(0.01, 0.0, 0.0)]) == 20.0
    assert movement.result is not None
    assert not movement.result.settled
    assert movement.result.error == pytest.approx(0.01)


@pytest.mark.parametrize("timeout", [0.5, 2.0, 7.5])
def test_a_timeout_of_its_own(timeout: float) -> None:
    movement = reach(tolerance=1e-6, timeout=timeout)
    assert settle_time(movement, 100 * [np.zeros(3)]) == timeout


def test_without_a_tip_it_runs_out_of_time() -> None:
    movement = reach()
    assert settle_time(movement, 100 * [None]) == 20.0
    assert movement.result is not None
    assert movement.result.tip is None
    assert math.isnan(movement.result.error)
    assert not movement.result.settled


def test_periods_without_a_tip_do_not_count_as_rest() -> None:
    movement = reach()
    tips = [*3 * [THERE], *10 * [None], *10 * [THERE]]
    assert settle_time(movement, tips) == 0.5 * (3 + 10 + 3)


def test_only_the_coordinates_of_the_task_count() -> None:
    """z is open in two dimensions: no error, but a tip that moves along it is not at rest."""
    movement = reach(timeout=10.0)
    tips = (off(0.0, 0.0, 0.01 * k) for k in range(100))
    assert settle_time(movement, tips) == 10.0
    assert movement.error == pytest.approx(0.0)
    deep = Reach(SPACE, SETTINGS, THERE)
    deep.update(off(0.0, 0.0, 0.03))
    assert deep.error == pytest.approx(0.03)
