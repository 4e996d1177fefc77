"""Inertia of a trunk that swings, read from its motion."""

import numpy as np
import pytest

from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics
from bha_pressure_ctrl.inertia import fit_inertia, through_valves

PERIOD = 0.02
STIFFNESS, DAMPING = 1.2e6, 1e5  # [Pa/m], [Pa s/m]
DYNAMICS = BellowsDynamics(dead_time=0.06, fill_lag=0.2, vent_lag=0.3)


def swinging(heavy: float, seconds: float = 120.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Let a trunk of known numbers move; return the directions it swings in, lengths, pressures.

    Random steps of all pressures, 1.5 s each, behind valves. In two directions (columns) it weighs
    `heavy` [Pa s^2/m], in all others a thirtieth of 2e4.
    """
    rng = np.random.default_rng(0)
    directions = np.linalg.qr(rng.standard_normal((9, 9)))[0][:, :2]
    inertia = 2e4 / 30.0 * np.eye(9) + heavy * directions @ directions.T
    levels = rng.uniform(3e4, 9e4, (round(seconds / 1.5), 9))
    asked = np.repeat(levels, round(1.5 / PERIOD), axis=0)
    at_readings = through_valves(asked, DYNAMICS, PERIOD)
    inside = np.vstack([at_readings[1:], at_readings[-1:]])  # while each answer acts
    inverse, parts = np.linalg.inv(inertia), 20
    length, speed, lengths = asked[0] / STIFFNESS, np.zeros(9), []
    for pressures in inside:
        lengths.append(length)
        for _ in range(parts):
            force = pressures - STIFFNESS * length - DAMPING * speed
            speed = speed + PERIOD / parts * (inverse @ force)
            length = length + PERIOD / parts * speed
    return directions, np.array(lengths), asked


@pytest.mark.parametrize("noise", [0.0, 5e-4])
def test_the_swings_of_a_known_trunk_are_found(noise: float) -> None:
    directions, lengths, asked = swinging(2e4)
    lengths = lengths + noise * np.random.default_rng(1).standard_normal(lengths.shape)
    inertia = fit_inertia(lengths, asked, STIFFNESS * lengths, DYNAMICS, PERIOD)
    np.testing.assert_allclose(inertia, inertia.T, atol=1e-6)
    values, vectors = np.linalg.eigh(inertia)
    np.testing.assert_allclose(values[:-2], 0.0, atol=1e-6)
    np.testing.assert_allclose(values[-2:], 2e4, rtol=0.15)
    np.testing.assert_allclose(np.linalg.svd(directions.T @ vectors[:, -2:])[1], 1.0, atol=0.03)


def test_a_light_trunk_is_found_light() -> None:
    _, lengths, asked = swinging(0.0)
    inertia = fit_inertia(lengths, asked, STIFFNESS * lengths, DYNAMICS, PERIOD)
    assert np.linalg.eigvalsh(inertia).max() < 2e3


@pytest.mark.parametrize("seconds", [4.5, 60.0])
def test_too_little_motion_tells_nothing(seconds: float) -> None:
    _, lengths, asked = swinging(2e4, seconds)
    if seconds > 10.0:
        lengths = np.full_like(lengths, 0.2)
    inertia = fit_inertia(lengths, asked, STIFFNESS * lengths, DYNAMICS, PERIOD)
    np.testing.assert_array_equal(inertia, 0.0)


def test_valves_fill_and_vent_after_the_dead_time() -> None:
    asked = np.repeat([[0.0], [1e5], [0.0]], [1, 100, 100], axis=0) * np.ones(9)
    inside = through_valves(asked, DYNAMICS, PERIOD)[:, 0]
    ticks = np.arange(1, 90)
    np.testing.assert_array_equal(inside[:5], 0.0)  # told at 1, and 3 of dead time
    np.testing.assert_allclose(inside[5:94], 1e5 * -np.expm1(-ticks * PERIOD / 0.2), rtol=1e-9)
    np.testing.assert_allclose(
        inside[105:194], inside[104] * np.exp(-ticks * PERIOD / 0.3), rtol=1e-9
    )
