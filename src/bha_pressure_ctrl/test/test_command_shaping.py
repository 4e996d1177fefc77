"""How a command is brought on, against the lags that it is to make up for."""

from typing import Any

import numpy as np
import pytest

from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics
from bha_pressure_ctrl.bellows_memory import STATES
from bha_pressure_ctrl.command_shaping import CommandShaping, ShapingSettings

PERIOD = 0.02
LOW, HIGH = np.full(9, 0.2), np.full(9, 0.22)  # [m]
FROM, TO = np.full(9, 4e4), np.full(9, 6e4)  # [Pa]
NONE, TOP = np.zeros(9), np.full(9, 1.3e5)


def step(
    ticks: int = 500,
    shaping: ShapingSettings | None = None,
    measured: np.ndarray | None = None,
    top: float = 1e9,
    **dynamics: Any,
) -> tuple[np.ndarray, np.ndarray]:
    """Step from 40 to 60 kPa and from LOW to HIGH; return pressures and lengths of one bellows."""
    known = BellowsDynamics(**{"response_lag": 0.0, **dynamics})
    shaper = CommandShaping(
        shaping or ShapingSettings(0.0, 0.0), known, period=PERIOD, lengths=LOW, pressures=FROM
    )
    target, expected, pairs = np.concatenate([HIGH, TO]), LOW, []
    for _ in range(ticks):
        seen = expected if measured is None else measured
        applied, expected = shaper.update(target, seen, NONE - top, NONE + top)
        pairs.append((applied[0], expected[0]))
    pressures, lengths = np.array(pairs).T
    return pressures, lengths


def test_without_lags_a_command_is_there_at_once() -> None:
    pressures, lengths = step()
    np.testing.assert_array_equal(pressures, 6e4)
    np.testing.assert_array_equal(lengths, 0.22)


def test_a_step_becomes_a_rounded_ramp_that_ends() -> None:
    """Of 15 and then 5 periods; lengths and pressures go the same way."""
    pressures, lengths = step(40, ShapingSettings(0.4, 0.0))
    ramp = (pressures - 4e4) / 2e4
    np.testing.assert_allclose((lengths - 0.2) / 0.02, ramp, atol=1e-12)
    np.testing.assert_allclose(ramp[18:], 1.0, rtol=1e-12)
    assert ramp[17] < 1.0
    assert (np.diff(ramp) > -1e-12).all()
    assert np.diff(ramp).max() == pytest.approx(1.0 / 15.0)


def test_what_the_inertia_costs_is_paid_while_it_is_accelerated() -> None:
    inertia = 1e4 * np.eye(9)
    heavy, lengths = step(40, ShapingSettings(0.4, 0.0), inertia=inertia)
    light, _ = step(40, ShapingSettings(0.4, 0.0))
    accelerated = np.diff(np.concatenate([[0.2, 0.2], lengths]), n=2) / PERIOD**2
    np.testing.assert_allclose(heavy - light, 1e4 * accelerated, atol=1e-3)
    assert np.abs(heavy - light).max() > 1e3


@pytest.mark.parametrize(("fill", "vent"), [(0.1, 0.1), (0.3, 0.2), (0.2, 0.6)])
def test_behind_the_valves_pressures_are_what_they_would_be_without_them(
    fill: float, vent: float
) -> None:
    """Up and, as the memory of the bellows fades, down again."""
    memory = np.full((STATES, 9), 1e6)
    shaping = ShapingSettings(0.4, 0.0)
    applied, _ = step(shaping=shaping, memory=memory, fill_lag=fill, vent_lag=vent)
    wanted, _ = step(shaping=shaping, memory=memory)
    pressure, behind = 4e4, []
    for value in applied:
        lag = fill if value > pressure else vent
        pressure += -np.expm1(-PERIOD / lag) * (value - pressure)
        behind.append(pressure)
    np.testing.assert_allclose(behind, wanted, rtol=1e-9)
    assert np.diff(wanted).min() < 0.0 < np.diff(wanted).max()
    assert np.abs(applied - wanted).max() > 1e3


def test_what_the_range_takes_away_is_made_up_for_later() -> None:
    """It stays at the end of the range until the valves are where they would be without it."""
    shaping = ShapingSettings(0.2, 0.0)
    applied, _ = step(shaping=shaping, fill_lag=0.3, vent_lag=0.3, top=6.5e4)
    wanted, _ = step(shaping=shaping)
    assert applied.max() == 6.5e4
    assert applied[10] == 6.5e4
    assert wanted[10] == pytest.approx(6e4)
    pressure = 4e4
    for value in applied:
        pressure += -np.expm1(-PERIOD / 0.3) * (value - pressure)
    assert pressure == pytest.approx(6e4, rel=1e-9)


def test_dead_time_and_lags_delay_what_is_expected() -> None:
    """Those of the settings and of a robot that was not asked add up."""
    for shaping, lag in ((ShapingSettings(0.0, 0.1), 0.0), (ShapingSettings(0.0, 0.06), 0.04)):
        _, lengths = step(shaping=shaping, dead_time=0.06, response_lag=lag)
        np.testing.assert_array_equal(lengths[:3], 0.2)
        ticks = np.arange(1, 20)
        np.testing.assert_allclose(lengths[3:22], 0.22 - 0.02 * np.exp(-ticks * PERIOD / 0.1))


def test_what_the_bellows_remember_is_paid_and_fades() -> None:
    memory = np.zeros((STATES, 9))
    memory[0] = 3e5  # [Pa/m], creep of 2 s
    pressures, _ = step(memory=memory)
    ticks = np.arange(1, 501)
    np.testing.assert_allclose(pressures, 6e4 + 6e3 * np.exp(-ticks * PERIOD / 2.0))


@pytest.mark.parametrize(("apart", "counts"), [(0.003, False), (0.015, True)])
def test_where_the_robot_really_was_is_remembered_when_that_is_far(
    apart: float, counts: bool
) -> None:
    """A bellows that did not come along has not crept as commanded."""
    memory = np.zeros((STATES, 9))
    memory[1] = 3e5  # creep of 10 s
    held, _ = step(memory=memory, measured=HIGH - apart)
    followed, _ = step(memory=memory, measured=HIGH)
    assert (np.abs(held - followed).max() > 100.0) == counts


@pytest.mark.parametrize("wrong", [{"smoothing_time": -0.1}, {"response_lag": 9.0}])
def test_settings_out_of_range(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        ShapingSettings(**wrong)
