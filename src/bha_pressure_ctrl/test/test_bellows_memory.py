"""What bellows remember, and what pressure that is found to cost."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from bha_pressure_ctrl.bellows_memory import (
    CREEP_TIMES,
    FRICTION_WIDTHS,
    STATES,
    BellowsMemory,
    fit_memory,
    friction_in_control,
)

PERIOD = 0.02
CREEPS = len(CREEP_TIMES)
START = np.full(9, 0.2)


def follow(lengths: np.ndarray, period: float = PERIOD) -> np.ndarray:
    """Return the states for lengths of shape (n, 9)."""
    memory = BellowsMemory(lengths[0], period)
    return np.array([memory.update(each) for each in lengths])


def test_at_rest_nothing_is_remembered() -> None:
    np.testing.assert_array_equal(follow(np.tile(START, (50, 1))), 0.0)


def test_creep_fades_with_its_times() -> None:
    memory = BellowsMemory(START, PERIOD)
    states = np.array([memory.update(START + 0.01) for _ in range(500)])
    ticks = np.arange(1, 501)[:, None]
    expected = 0.01 * np.exp(-ticks * PERIOD / CREEP_TIMES)
    np.testing.assert_allclose(states[:, :CREEPS, 3], expected, rtol=1e-9)


def test_friction_follows_until_it_slips_and_at_once_turns_with_the_way() -> None:
    up = 0.2 + np.linspace(0.0, 0.02, 201)
    way = np.concatenate([up, up[-2::-1]])
    states = follow(np.repeat(way[:, None], 9, axis=1))[:, CREEPS:, 0]
    for width, friction in zip(FRICTION_WIDTHS, states.T, strict=True):
        np.testing.assert_allclose(friction[:201], np.minimum(up - 0.2, width), atol=1e-12)
        down = np.maximum(width - (up[-1] - way[200:]), -width)
        np.testing.assert_allclose(friction[200:], down, atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(hnp.arrays(np.float64, (20, 9), elements=st.floats(0.1, 0.4)))
def test_friction_stays_within_its_widths_however_fast(lengths: np.ndarray) -> None:
    states = follow(lengths)[:, CREEPS:]
    assert (np.abs(states) <= FRICTION_WIDTHS[:, None]).all()
    twice = follow(np.repeat(lengths, 2, axis=0))[1::2, CREEPS:]  # half as fast
    np.testing.assert_array_equal(twice, states)


def test_the_weights_of_a_known_robot_are_found() -> None:
    """Beside stiffness, coupling, hardening, a drift in time, and noise."""
    rng = np.random.default_rng(0)
    posture = rng.uniform(-0.03, 0.03, (60, 9))
    lengths = 0.2 + np.repeat(posture, 6, axis=0)
    states = follow(lengths, period=1.0)
    weights = rng.uniform(1e5, 5e5, (STATES, 9))
    times = np.arange(len(lengths), dtype=float)
    x = lengths - 0.2
    slope = 1e6 * (np.eye(9) + 0.1 * rng.standard_normal((9, 9)))
    pressures = 6e4 + x @ slope.T + 3e7 * x**3 / 0.05 + 10.0 * times[:, None]
    pressures += (weights * states).sum(axis=1) + 50.0 * rng.standard_normal(x.shape)
    fitted = fit_memory(lengths, pressures, states, times)
    told, known = ((each * states).sum(axis=1) for each in (fitted, weights))
    assert np.sqrt(np.mean((told - known) ** 2)) < 0.1 * np.sqrt(np.mean(known**2))


def test_no_weight_drives_a_bellows_on() -> None:
    """Creep and friction only ever cost pressure: numbers that say otherwise are not believed."""
    rng = np.random.default_rng(1)
    lengths = 0.2 + np.repeat(rng.uniform(-0.03, 0.03, (40, 9)), 5, axis=0)
    states = follow(lengths, period=1.0)
    pressures = 1e6 * (lengths - 0.15) - 3e5 * states.sum(axis=1)
    weights = fit_memory(lengths, pressures, states, np.arange(200.0))
    assert (weights >= 0.0).all()
    assert weights.max() < 1e5


@pytest.mark.parametrize("count", [1, 5])
def test_what_was_told_stays_as_it_was(count: int) -> None:
    memory = BellowsMemory(START, PERIOD)
    told = memory.update(START + 0.001)
    before = told.copy()
    for _ in range(count):
        memory.update(START - 0.01)
    np.testing.assert_array_equal(told, before)


def test_control_meets_half_of_the_friction_and_all_of_the_creep() -> None:
    weights = np.arange(1.0, 1.0 + STATES * 9).reshape(STATES, 9)
    kept = friction_in_control(weights)
    creeps = len(CREEP_TIMES)
    np.testing.assert_array_equal(kept[:creeps], weights[:creeps])
    np.testing.assert_array_equal(kept[creeps:], 0.5 * weights[creeps:])
