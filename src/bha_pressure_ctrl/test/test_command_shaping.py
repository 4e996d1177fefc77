"""How a command is brought on, against the lags that it is to make up for."""

from typing import Any

import numpy as np
import pytest

from bha_pressure_ctrl.command_shaping import CommandShaping, ShapingSettings

PERIOD = 0.02
LOW, HIGH = np.full(9, 0.2), np.full(9, 0.22)  # [m]
PLAIN = {
    "smoothing_time": 0.0,
    "valve_lag": 0.0,
    "creep_share": 0.0,
    "dead_time": 0.0,
    "response_lag": 0.0,
}


def step(ticks: int = 500, **changes: Any) -> tuple[np.ndarray, np.ndarray]:
    """Step from 40 to 60 kPa and from LOW to HIGH; return pressures [kPa] and lengths of one."""
    start = np.full(9, 40.0)
    settings = ShapingSettings(**{**PLAIN, **changes})
    shaping = CommandShaping(settings, period=PERIOD, lengths=LOW, pressures=start)
    pairs = [shaping.update(HIGH, start + 20.0) for _ in range(ticks)]
    return np.array([p[0] for p, _ in pairs]), np.array([q[0] for _, q in pairs])


def test_without_lags_a_command_is_there_at_once() -> None:
    pressures, lengths = step()
    np.testing.assert_array_equal(pressures, 60.0)
    np.testing.assert_array_equal(lengths, 0.22)


def test_everything_comes_to_the_command() -> None:
    pressures, lengths = (values[-1] for values in step(3000, **vars(ShapingSettings())))
    assert pressures == pytest.approx(60.0, abs=1e-3)
    assert lengths == pytest.approx(0.22, abs=1e-9)


@pytest.mark.parametrize("lag", [0.1, 0.3, 0.6])
def test_the_lead_makes_up_for_the_lag_of_the_valves(lag: float) -> None:
    """Behind such a valve, the pressures are what they would be without it and the lead."""
    applied, _ = step(smoothing_time=0.15, valve_lag=lag)
    wanted, _ = step(smoothing_time=0.15)
    pressure, behind = 40.0, []
    for value in applied:
        pressure += -np.expm1(-PERIOD / lag) * (value - pressure)
        behind.append(pressure)
    # What is left comes of the finite period.
    assert np.abs(np.array(behind) - wanted).max() < 20.0 * 0.5 * PERIOD / 0.15
    unled = np.abs(np.array(applied) - wanted).max()
    assert unled > 4.5  # three times that


def test_dead_time_and_lag_delay_what_is_expected() -> None:
    _, lengths = step(dead_time=0.06, response_lag=0.1)
    np.testing.assert_array_equal(lengths[:3], 0.2)
    ticks = np.arange(1, 20)
    np.testing.assert_allclose(lengths[3:22], 0.22 - 0.02 * np.exp(-ticks * PERIOD / 0.1))


def test_the_surplus_fades_with_the_creep() -> None:
    pressures, _ = step(creep_share=0.2, creep_time=1.0)
    ticks = np.arange(1, 501)
    np.testing.assert_allclose(pressures, 60.0 + 4.0 * np.exp(-ticks * PERIOD / 1.0))


@pytest.mark.parametrize("wrong", [{"smoothing_time": -0.1}, {"creep_time": 0.0}])
def test_settings_out_of_range(wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        ShapingSettings(**wrong)
