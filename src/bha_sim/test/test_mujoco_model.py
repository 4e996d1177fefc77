"""The trunk's mechanics against calculations by hand."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from bha_sim.mujoco_model import TrunkModel, build_model
from bha_sim.robot_parameters import RobotParameters, draw_robot, load_parameters

STEP = 0.02


def build(parameters: RobotParameters) -> tuple[TrunkModel, mujoco.MjData]:
    """Model with the lasting springs only, at its reference posture."""
    pieces = 9 * parameters.trunk.discs_per_segment
    trunk = build_model(parameters, np.ones(pieces), STEP)
    data = mujoco.MjData(trunk.model)
    mujoco.mj_forward(trunk.model, data)
    return trunk, data


def weightless(parameters: RobotParameters, hardening: float = 0.0) -> RobotParameters:
    return replace(
        parameters,
        trunk=replace(parameters.trunk, gravity=0.0),
        bellows=replace(parameters.bellows, hardening=hardening),
    )


def settle(trunk: TrunkModel, data: mujoco.MjData, pressures: np.ndarray) -> None:
    data.ctrl[:] = pressures
    mujoco.mj_step(trunk.model, data, nstep=3000)
    assert np.abs(data.qvel).max() < 1e-7
    mujoco.mj_forward(trunk.model, data)


def test_the_masses_are_those_of_the_file():
    parameters = draw_robot(load_parameters(), 1)
    trunk, _ = build(parameters)
    expected = parameters.trunk.segment_masses.sum() + parameters.trunk.tool_mass
    assert trunk.model.body_mass.sum() == pytest.approx(expected, rel=1e-12)


def test_a_disc_has_the_inertia_of_a_solid_cylinder():
    parameters = load_parameters().trunk
    trunk, _ = build(load_parameters())
    mass, radius = parameters.segment_masses[1] / 3, parameters.bellows_radii[1]
    across = mass * (3 * radius**2 + parameters.disc_thickness**2) / 12
    inertia = np.sort(trunk.model.body("disc_2_2").inertia)
    np.testing.assert_allclose(inertia, [across, across, mass * radius**2 / 2], rtol=1e-12)


def test_the_rest_lengths_are_those_of_the_file():
    parameters = load_parameters()
    trunk, data = build(parameters)
    np.testing.assert_allclose(data.ten_length[trunk.bellows], 0.15, rtol=1e-12)
    np.testing.assert_allclose(data.ten_length[trunk.pieces], 0.0, atol=1e-15)
    np.testing.assert_allclose(data.xpos[trunk.tip_body], [0.0, 0.0, 0.65], atol=1e-12)


@pytest.mark.parametrize("segment", range(3))
def test_pressure_times_area_is_stiffness_times_extension(segment):
    parameters = weightless(load_parameters(), hardening=4e4)
    trunk, data = build(parameters)
    pressures = np.zeros(9)
    pressures[3 * segment : 3 * segment + 3] = 6e4
    settle(trunk, data, pressures)
    extension = data.ten_length[trunk.bellows] - 0.15
    elastic = parameters.bellows
    # F = k e + c (e - e0)^3, with F = p A, for every bellows, driven or not.
    force = elastic.stiffness * extension
    force += elastic.hardening * (extension - elastic.hardening_extension) ** 3
    np.testing.assert_allclose(force, pressures * elastic.areas, atol=1e-6)
    assert extension[3 * segment] > 0.09


def test_bending_and_stretching_by_one_bellows():
    parameters = weightless(load_parameters())
    trunk, data = build(parameters)
    pressures = np.zeros(9)
    pressures[0] = 50.0
    settle(trunk, data, pressures)
    force, k, b = 50.0 * 1e-3, 540.0, 0.1
    lengths = data.ten_length[trunk.bellows][:3] - 0.15
    # Mean extension F/(3 k); the moment F b bends by F b/(1.5 b^2 k), so that all comes from
    # the driven bellows and none from the others, which carry no force.
    np.testing.assert_allclose(lengths, [force / k, 0.0, 0.0], atol=2e-4 * force / k)
    angle = np.arctan2(-data.xmat[trunk.tip_body][2], data.xmat[trunk.tip_body][8])
    assert angle == pytest.approx(force * b / (1.5 * b**2 * k), rel=1e-3)


def test_the_trunk_bends_away_from_bellows_1_which_is_at_x():
    trunk, data = build(weightless(load_parameters()))
    pressures = np.zeros(9)
    pressures[[0, 3, 6]] = 2e4
    settle(trunk, data, pressures)
    x, y, _ = data.xpos[trunk.tip_body]
    assert x < -0.1
    assert abs(y) < 1e-9


def test_pieces_in_series_have_the_stiffness_of_their_bellows():
    parameters = weightless(draw_robot(load_parameters(), 2))
    trunk, data = build(parameters)
    force = 0.01 * parameters.bellows.stiffness
    settle(trunk, data, force / parameters.bellows.areas)
    # The pieces differ, but each bellows as a whole stretches by what its own spring does.
    np.testing.assert_allclose(data.ten_length[trunk.bellows] - 0.15, 0.01, rtol=2e-2)


def test_the_weight_hangs_on_the_bellows():
    parameters = replace(
        load_parameters(), bellows=replace(load_parameters().bellows, hardening=0.0)
    )
    trunk, data = build(parameters)
    settle(trunk, data, np.zeros(9))
    masses = np.append(parameters.trunk.segment_masses / 3, parameters.trunk.tool_mass)
    below = np.cumsum(np.repeat(masses, [3, 3, 3, 1])[::-1])[::-1][:9]
    stretch = below * 9.81 / (3 * parameters.bellows.piece_stiffness[::3].ravel())
    expected = stretch.reshape(3, 3).sum(axis=1)
    np.testing.assert_allclose(
        data.ten_length[trunk.bellows].reshape(3, 3), 0.15 + expected[:, None].repeat(3, 1)
    )


def test_mujoco_does_not_reset_itself_and_solves_no_constraints():
    trunk, data = build(load_parameters())
    disabled = trunk.model.opt.disableflags
    assert disabled & mujoco.mjtDisableBit.mjDSBL_AUTORESET
    assert disabled & mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    assert data.nefc == 0
    assert trunk.model.nv == 36
