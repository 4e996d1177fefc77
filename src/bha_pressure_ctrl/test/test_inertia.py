"""Inertia of a trunk that swings, read from its motion."""

import numpy as np
import pytest

from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics
from bha_pressure_ctrl.inertia import fit_inertia, through_valves

PERIOD = 0.02
STIFFNESS, DAMPING = 1.2e6, 1e5  # [Pa/m], [Pa s/m]
DYNAMICS = BellowsDynamics(dead_time=0.06, fill_lag=0.2, vent_lag=0.3)


LIGHT = 2e4 / 30.0  # [Pa s^2/m] that stretching a segment weighs, too
HEAVY = np.array([[12e3, 5e3, 2e3], [5e3, 5e3, 2e3], [2e3, 2e3, 2e3]])
"""What bending weighs beside that, segment by segment [Pa s^2/m]: the base carries the others."""


def trunk(bending: np.ndarray) -> np.ndarray:
    """Return the inertia (9, 9) of a trunk whose bends weigh a matrix (3, 3) more than stretches.

    The two directions sideways of three bellows are all that is not their mean.
    """
    sideways = np.eye(3) - 1.0 / 3.0
    return LIGHT * np.eye(9) + np.kron(bending, sideways)


def swinging(
    bending: np.ndarray, seconds: float = 120.0, hoses: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Let a trunk of known numbers move; return lengths and the pressures asked for.

    Random steps of all pressures, 1.5 s each, behind valves and a second lag of `hoses` [s].
    """
    rng = np.random.default_rng(0)
    levels = rng.uniform(3e4, 9e4, (round(seconds / 1.5), 9))
    asked = np.repeat(levels, round(1.5 / PERIOD), axis=0)
    at_readings = through_valves(asked, DYNAMICS, PERIOD)
    behind = np.vstack([at_readings[1:], at_readings[-1:]])  # while each answer acts
    inverse, parts = np.linalg.inv(trunk(bending)), 20
    length, speed, lengths = asked[0] / STIFFNESS, np.zeros(9), []
    inside, share = asked[0], PERIOD / parts / hoses if hoses else 1.0
    for pressures in behind:
        lengths.append(length)
        for _ in range(parts):
            inside = inside + share * (pressures - inside)
            force = inside - STIFFNESS * length - DAMPING * speed
            speed = speed + PERIOD / parts * (inverse @ force)
            length = length + PERIOD / parts * speed
    return np.array(lengths), asked


@pytest.mark.parametrize(("noise", "hoses"), [(0.0, 0.0), (5e-4, 0.0), (0.0, 0.06)])
def test_what_bending_a_known_trunk_costs_is_found(noise: float, hoses: float) -> None:
    """Also behind hoses that nothing was identified of: stretching shows what they do."""
    lengths, asked = swinging(HEAVY, hoses=hoses)
    lengths = lengths + noise * np.random.default_rng(1).standard_normal(lengths.shape)
    inertia = fit_inertia(lengths, asked, STIFFNESS * lengths, DYNAMICS, PERIOD)
    np.testing.assert_allclose(inertia, inertia.T, atol=1e-6)
    expected = np.kron(HEAVY, np.eye(3) - 1.0 / 3.0)
    assert np.linalg.norm(inertia - expected) < 0.2 * np.linalg.norm(expected)
    tip = inertia[6, 6] / expected[6, 6]
    assert 0.6 < tip < 1.4


def test_the_direction_of_a_bend_does_not_matter() -> None:
    """Nor where the first bellows of a segment is."""
    lengths, asked = swinging(HEAVY)
    inertia = fit_inertia(lengths, asked, STIFFNESS * lengths, DYNAMICS, PERIOD)
    order = [1, 2, 0, 4, 5, 3, 7, 8, 6]
    turned = fit_inertia(
        lengths[:, order], asked[:, order], STIFFNESS * lengths[:, order], DYNAMICS, PERIOD
    )
    np.testing.assert_allclose(turned, inertia, rtol=1e-6, atol=1e-3)
    mounted = [0, 1, 2, 4, 5, 3, 6, 7, 8]  # the middle segment alone
    turned = fit_inertia(
        lengths[:, mounted], asked[:, mounted], STIFFNESS * lengths[:, mounted], DYNAMICS, PERIOD
    )
    np.testing.assert_allclose(turned, inertia[np.ix_(mounted, mounted)], rtol=1e-6, atol=1e-3)


def test_a_light_trunk_is_found_light() -> None:
    lengths, asked = swinging(np.zeros((3, 3)))
    inertia = fit_inertia(lengths, asked, STIFFNESS * lengths, DYNAMICS, PERIOD)
    assert np.linalg.eigvalsh(inertia).max() < 1e3


@pytest.mark.parametrize("seconds", [4.5, 60.0])
def test_too_little_motion_tells_nothing(seconds: float) -> None:
    lengths, asked = swinging(HEAVY, seconds)
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
