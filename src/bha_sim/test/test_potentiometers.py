"""Noise, steps, play and drift of the measured lengths."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bha_sim.parameter_sections import PotentiometerParameters
from bha_sim.potentiometers import Potentiometers
from bha_sim.robot_parameters import load_parameters

PERIOD = 0.02
LENGTHS = np.linspace(0.15, 0.30, 9)


def make(seed: int = 0, **changes: object) -> Potentiometers:
    ideal: dict[str, object] = {"noise": 0.0, "resolution": 0.0, "play": 0.0, "drift_spread": 0.0}
    parameters = replace(load_parameters().potentiometers, **{**ideal, **changes})  # type: ignore[arg-type]
    assert isinstance(parameters, PotentiometerParameters)
    return Potentiometers(parameters, PERIOD, np.random.SeedSequence(seed), LENGTHS)


def read(potentiometers: Potentiometers, lengths: np.ndarray = LENGTHS) -> np.ndarray:
    out = np.empty(9)
    potentiometers.measure(lengths, out)
    return out


def test_an_ideal_one_tells_the_length():
    np.testing.assert_array_equal(read(make()), LENGTHS)


def test_noise_is_white_and_has_its_spread():
    potentiometers = make(noise=0.5e-3)
    errors = np.array([read(potentiometers) - LENGTHS for _ in range(5000)])
    assert errors.std() == pytest.approx(0.5e-3, rel=0.02)
    assert abs(errors.mean()) < 4 * 0.5e-3 / np.sqrt(errors.size)
    neighbours = np.mean(errors[1:] * errors[:-1]) / 0.5e-3**2
    assert abs(neighbours) < 4 / np.sqrt(errors.size)
    across = np.corrcoef(errors.T) - np.eye(9)
    assert np.abs(across).max() < 0.08


def test_readings_are_whole_steps():
    readings = read(make(noise=0.5e-3, resolution=0.25e-3))
    steps = readings / 0.25e-3
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)
    np.testing.assert_allclose(read(make(resolution=0.25e-3)), LENGTHS, atol=0.125e-3 + 1e-12)


def test_play_hides_small_motions_and_depends_on_the_direction():
    potentiometers = make(play=0.7e-3)
    np.testing.assert_allclose(read(potentiometers, LENGTHS + 0.3e-3), LENGTHS)
    np.testing.assert_allclose(read(potentiometers, LENGTHS + 2e-3), LENGTHS + 2e-3 - 0.35e-3)
    np.testing.assert_allclose(read(potentiometers, LENGTHS + 1.5e-3), LENGTHS + 2e-3 - 0.35e-3)
    np.testing.assert_allclose(read(potentiometers, LENGTHS), LENGTHS + 0.35e-3)


def test_drift_keeps_its_spread_and_forgets_within_its_time():
    spread, time = 0.6e-3, 10.0
    potentiometers = make(drift_spread=spread, drift_time=time)
    errors = np.array([read(potentiometers) - LENGTHS for _ in range(100_000)])
    # 9 potentiometers over 2000 s: 900 independent values, so 3 standard errors are 7 %.
    assert errors.std() == pytest.approx(spread, rel=0.1)
    lag = round(time / PERIOD)
    correlation = np.mean(errors[lag:] * errors[:-lag]) / errors.var()
    assert correlation == pytest.approx(np.exp(-1.0), abs=0.1)
    assert np.abs(np.diff(errors, axis=0)).max() < 6 * spread * np.sqrt(2 * PERIOD / time)


def test_offset_and_gain_belong_to_each_potentiometer():
    offsets, gains = np.linspace(-3e-3, 3e-3, 9), np.linspace(0.99, 1.01, 9)
    np.testing.assert_allclose(
        read(make(offsets=offsets, gains=gains)), gains * LENGTHS + offsets, rtol=1e-15
    )


def test_seeds_name_the_noise():
    np.testing.assert_array_equal(read(make(1, noise=1e-3)), read(make(1, noise=1e-3)))
    assert not np.any(read(make(1, noise=1e-3)) == read(make(2, noise=1e-3)))


def test_the_state_brings_back_cables_drift_and_noise():
    potentiometers = make(noise=1e-3, play=1e-3, drift_spread=1e-3)
    read(potentiometers, LENGTHS + 0.01)
    state = potentiometers.state
    expected = read(potentiometers)
    read(potentiometers, LENGTHS - 0.05)
    potentiometers.state = state
    np.testing.assert_array_equal(read(potentiometers), expected)
