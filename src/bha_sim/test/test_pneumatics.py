"""Dead time, lag, play and sensors of the pressures against their formulas."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bha_sim.parameter_sections import PneumaticParameters
from bha_sim.pneumatics import Pneumatics
from bha_sim.robot_parameters import load_parameters

PERIOD = 0.02


def make(seed: int = 0, **changes: object) -> Pneumatics:
    ideal: dict[str, object] = {
        "regulator_play": 0.0,
        "sensor_noise": 0.0,
        "sensor_resolution": 0.0,
    }
    parameters = replace(load_parameters().pneumatics, **{**ideal, **changes})  # type: ignore[arg-type]
    assert isinstance(parameters, PneumaticParameters)
    return Pneumatics(parameters, PERIOD, np.random.SeedSequence(seed))


def run(pneumatics: Pneumatics, command: float, ticks: int) -> np.ndarray:
    return np.array([pneumatics.step(np.full(9, command))[0] for _ in range(ticks)])


def read(pneumatics: Pneumatics) -> np.ndarray:
    out = np.empty(9)
    pneumatics.measure(out)
    return out


def test_filling_is_a_first_order_lag_after_the_dead_time():
    pressures = run(make(dead_time=0.06, fill_time_constant=0.25), 1e5, 100)
    assert np.all(pressures[:3] == 0.0)
    elapsed = PERIOD * np.arange(1, 98)
    np.testing.assert_allclose(pressures[3:], 1e5 * (1.0 - np.exp(-elapsed / 0.25)), rtol=1e-12)


def test_venting_has_a_lag_of_its_own():
    pneumatics = make(dead_time=0.0, fill_time_constant=0.01, vent_time_constant=0.35)
    full = run(pneumatics, 1e5, 500)[-1]
    pressures = run(pneumatics, 2e4, 100)
    elapsed = PERIOD * np.arange(1, 101)
    expected = 2e4 + (full - 2e4) * np.exp(-elapsed / 0.35)
    np.testing.assert_allclose(pressures, expected, rtol=1e-12)


def test_the_regulator_ignores_commands_within_its_play():
    pneumatics = make(dead_time=0.0, regulator_play=500.0)
    up = run(pneumatics, 5e4, 1000)[-1]
    assert up == pytest.approx(5e4 - 250.0)
    assert run(pneumatics, 4.96e4, 1000)[-1] == pytest.approx(up)
    assert run(pneumatics, 4e4, 1000)[-1] == pytest.approx(4e4 + 250.0)


def test_zero_vents_fully_in_spite_of_the_play():
    pneumatics = make(dead_time=0.0, regulator_play=500.0)
    run(pneumatics, 5e4, 1000)
    assert run(pneumatics, 0.0, 1000)[-1] == pytest.approx(0.0, abs=1e-6)


def test_sensors_have_the_noise_and_steps_they_should():
    pneumatics = make(sensor_noise=100.0, sensor_resolution=50.0, dead_time=0.0)
    run(pneumatics, 5e4, 1000)
    readings = np.array([read(pneumatics) for _ in range(4000)])
    steps = readings / 50.0
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)
    assert readings.mean() == pytest.approx(5e4, abs=4 * 100.0 / np.sqrt(readings.size))
    # Rounding adds the variance of a uniform step.
    assert readings.std() == pytest.approx(np.hypot(100.0, 50.0 / np.sqrt(12.0)), rel=0.02)


def test_the_state_brings_back_queue_pressures_and_noise():
    pneumatics = make(sensor_noise=100.0, regulator_play=500.0)
    run(pneumatics, 8e4, 7)
    state = pneumatics.state
    first = run(pneumatics, 3e4, 5), read(pneumatics)
    run(pneumatics, 1e5, 11)
    pneumatics.state = state
    again = run(pneumatics, 3e4, 5), read(pneumatics)
    np.testing.assert_array_equal(first[0], again[0])
    np.testing.assert_array_equal(first[1], again[1])


def test_a_reset_is_as_new():
    pneumatics = make(seed=4, sensor_noise=100.0)
    run(pneumatics, 8e4, 50)
    pneumatics.reset(np.random.SeedSequence(4))
    fresh = make(seed=4, sensor_noise=100.0)
    np.testing.assert_array_equal(run(pneumatics, 5e4, 20), run(fresh, 5e4, 20))
    np.testing.assert_array_equal(read(pneumatics), read(fresh))
