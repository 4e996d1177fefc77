"""Creep and hysteresis against their formulas, and the passivity of both."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_sim import visco_elasticity
from bha_sim.parameter_sections import Hysteresis, Relaxation
from bha_sim.visco_elasticity import ViscoElasticity

PERIOD = 0.02
PIECES = 27


def material(tau=(2.0,), creep=(0.5,), slip=(0.001,), friction=(0.25,)) -> ViscoElasticity:
    relaxation = Relaxation(time_constants=np.array(tau), shares=np.array(creep))
    hysteresis = Hysteresis(slips=np.array(slip), shares=np.array(friction))
    return ViscoElasticity(relaxation, hysteresis, discs=3, period=PERIOD)


def force(visco: ViscoElasticity, extension: float, times: int = 1) -> float:
    """Force of a piece over its lasting stiffness [m] after holding an extension."""
    centres = np.empty(PIECES)
    for _ in range(times):
        visco.update(np.full(PIECES, extension), centres)
    forces = visco.stiffness_factors * (extension - centres)
    assert np.ptp(forces) < 1e-15
    return float(forces[0])


def test_the_whole_stiffness_is_the_sum_of_all_springs():
    np.testing.assert_allclose(material().stiffness_factors, 1.0 + 0.5 + 0.25)


def test_a_held_extension_relaxes_exponentially():
    visco = material(friction=(0.0,))
    for ticks in (1, 49, 50):
        force(visco, 0.01, ticks)
    elapsed = 100 * PERIOD
    expected = 0.01 * (1.0 + 0.5 * np.exp(-(elapsed + PERIOD) / 2.0))
    assert force(visco, 0.01) == pytest.approx(expected, rel=1e-12)


def test_sliders_hold_the_slip_force_and_turn_it_round():
    visco = material(creep=(0.0,))
    assert force(visco, 0.0005) == pytest.approx(0.0005 * 1.25)
    assert force(visco, 0.010) == pytest.approx(0.010 + 0.25 * 0.001)
    # Half way back through the loop the slider still sticks.
    assert force(visco, 0.009) == pytest.approx(0.009)
    assert force(visco, 0.005) == pytest.approx(0.005 - 0.25 * 0.001)


def test_a_closed_loop_dissipates_four_slips_times_the_amplitude():
    visco = material(creep=(0.0,), slip=(0.001,), friction=(0.25,))
    path = np.concatenate([np.linspace(0, 0.01, 2001), np.linspace(0.01, -0.01, 4001)])
    path = np.concatenate([path, np.linspace(-0.01, 0.01, 4001)])
    forces = np.array([force(visco, extension) for extension in path])
    loop = slice(2000, None)
    middle = 0.5 * (forces[loop][1:] + forces[loop][:-1])
    work = float(np.sum(middle * np.diff(path[loop])))
    # A parallelogram: 4 F (a - slip) for slip force F and amplitude a.
    assert work == pytest.approx(4 * 0.25 * 0.001 * (0.01 - 0.001), rel=1e-3)


def stored(visco: ViscoElasticity, extension: np.ndarray, shares: np.ndarray) -> float:
    return float(0.5 * np.sum(shares * (extension - visco.state) ** 2))


@given(st.integers(0, 2**32), st.integers(1, 30))
@settings(max_examples=50, deadline=None)
def test_an_update_never_stores_energy(seed, steps):
    rng = np.random.default_rng(seed)
    visco = material((0.05, 3.0), (0.4, 0.6), (0.0005, 0.002), (0.3, 0.2))
    shares = np.array([0.4, 0.6, 0.3, 0.2])[:, None]
    centres = np.empty(PIECES)
    for _ in range(steps):
        extension = rng.normal(0.0, 0.01, PIECES)
        before = stored(visco, extension, shares)
        visco.update(extension, centres)
        assert stored(visco, extension, shares) <= before


def test_relaxing_forgets():
    visco, centres = material(), np.empty(PIECES)
    force(visco, 0.02, 10)
    extension = np.linspace(0.0, 0.01, PIECES)
    visco.relax(extension, centres)
    np.testing.assert_allclose(visco.stiffness_factors * (extension - centres), extension)


def test_the_state_is_a_copy():
    visco = material()
    force(visco, 0.01, 3)
    state = visco.state
    expected = force(visco, 0.02)
    force(visco, -0.02, 5)
    visco.state = state
    assert force(visco, 0.02) == expected


def test_compiled_and_interpreted_agree_to_the_bit():
    rng = np.random.default_rng(0)
    arguments = [
        rng.normal(0.0, 0.01, (4, PIECES)),
        rng.normal(0.0, 0.01, PIECES),
        rng.uniform(0.0, 1.0, 2),
        rng.uniform(0.0, 0.01, (2, PIECES)),
        rng.uniform(0.0, 1.0, (4, PIECES)),
        np.zeros(PIECES),
    ]
    slow = [argument.copy() for argument in arguments]
    visco_elasticity._advance(*arguments)
    visco_elasticity._advance.py_func(*slow)
    for fast, interpreted in zip(arguments, slow, strict=True):
        np.testing.assert_array_equal(fast, interpreted)
