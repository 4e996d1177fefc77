"""Without pressure the trunk only ever loses mechanical energy.

The energy counts motion, weight, every spring at its own stretch (the lasting springs, the springs
of the creep branches, which end at their dampers, and those of the friction elements, which end at
their sliders), the cubic hardening and torsion. Dampers and sliders can only take from it.
"""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from bha_sim.disturbances import Disturbances
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters

MAX = 1.3e5
TICKS = 400
"""8 s: by then nothing but creep moves."""


def plant(robot: int) -> Plant:
    return Plant(draw_robot(load_parameters(), robot), seed=0)


def energy(robot: Plant) -> float:
    """Mechanical energy [J] from the robot's own parameters, not from what MuJoCo makes of them."""
    model, data, parameters = robot._mechanics.model, robot._mechanics.data, robot.parameters
    elastic, trunk = parameters.bellows, parameters.trunk
    discs = trunk.discs_per_segment
    matrix = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, matrix)
    total = 0.5 * data.qvel @ matrix @ data.qvel
    total -= trunk.gravity * model.body_mass @ data.xipos[:, 2]
    lasting = elastic.piece_stiffness.ravel()
    lasting = lasting * (1.0 - np.repeat(robot.disturbances.softening, discs))
    shares = np.vstack([parameters.relaxation.shares, parameters.hysteresis.shares])
    stretches = robot._extensions - robot._visco.state
    total += 0.5 * lasting @ robot._extensions**2
    total += 0.5 * np.sum(shares.repeat(discs, axis=1) * lasting * stretches**2)
    middle = trunk.segment_rest_lengths.repeat(3) + elastic.hardening_extension
    total += 0.25 * elastic.hardening @ (robot._lengths - middle) ** 4
    twists = np.array(["twist" in model.joint(index).name for index in range(model.njnt)])
    torsion = discs * trunk.torsion_stiffness.repeat(discs)
    total += 0.5 * torsion @ data.qpos[twists] ** 2
    return float(total)


def course(robot: Plant, ticks: int = TICKS) -> np.ndarray:
    """Energy at every tick from now on, all air let out at once."""
    robot._pneumatics.reset(np.random.SeedSequence(0))
    energies = [energy(robot)]
    for _ in range(ticks):
        robot.step(np.zeros(9))
        energies.append(energy(robot))
    return np.array(energies)


def push(robot: Plant, pressures: np.ndarray, duration: float) -> None:
    for _ in range(round(duration / robot.control_period)):
        robot.step(pressures)


def growth(energies: np.ndarray) -> float:
    """Largest growth in a tick over all that was lost [-]."""
    return float(np.diff(energies).max() / (energies[0] - energies[-1]))


@pytest.mark.parametrize("robot_seed", range(6))
def test_it_never_grows_after_any_posture(robot_seed):
    robot = plant(robot_seed)
    rng = np.random.default_rng(robot_seed)
    for pressures in (rng.uniform(0.0, MAX, 9), rng.choice([0.0, MAX], 9)):
        push(robot, pressures, 1.0)
        energies = course(robot)
        assert energies[0] - energies[-1] > 0.3
        assert growth(energies) <= 1e-9


@pytest.mark.parametrize("robot_seed", range(3))
def test_it_never_grows_after_a_blow(robot_seed):
    robot = plant(robot_seed)
    rng = np.random.default_rng(robot_seed)
    push(robot, rng.uniform(0.0, MAX, 9), 1.0)
    # As if struck: every joint gets a speed of its own, and the tip some metres a second.
    speeds = np.tile([0.5, 2.0, 2.0, 2.0], robot._mechanics.model.nv // 4)
    robot._mechanics.data.qvel[:] += speeds * rng.uniform(-1.0, 1.0, robot._mechanics.model.nv)
    mujoco.mj_step1(robot._mechanics.model, robot._mechanics.data)
    assert growth(course(robot)) <= 1e-9


def test_it_never_grows_with_a_payload_and_soft_bellows():
    robot = plant(1)
    robot.disturb(Disturbances(payload=0.5, softening=(0.3, 0.0, 0.2) * 3))
    push(robot, np.full(9, 0.8 * MAX), 1.0)
    assert growth(course(robot)) <= 1e-9


def test_pressure_does_bring_energy_in():
    """So the energy is one that can grow."""
    robot = plant(0)
    before = energy(robot)
    push(robot, np.full(9, 0.8 * MAX), 5.0)
    assert energy(robot) > before + 1.0
