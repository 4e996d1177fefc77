"""The whole plant: repeatable to the bit, passive, slow, guarded."""

from __future__ import annotations

import hashlib
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import bha_common
import bha_sim
from bha_sim.constant_curvature import tip_pose
from bha_sim.errors import PlantDivergedError
from bha_sim.plant import Plant
from bha_sim.plant_state import PlantState
from bha_sim.robot_parameters import draw_robot, load_parameters

MAX = 1.3e5


def plant(robot: int = 0, seed: int = 0, period: float = 0.02) -> Plant:
    return Plant(draw_robot(load_parameters(), robot), seed=seed, control_period=period)


def commands(count: int, seed: int = 0) -> np.ndarray:
    """Random steps of the pressures, each held for ten ticks."""
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, MAX, (count // 10 + 1, 9)).repeat(10, axis=0)[:count]


def bits(state: PlantState) -> bytes:
    arrays = (state.lengths, state.pressures, state.tip, state.tip_quaternion, state.true_lengths)
    return np.float64(state.time).tobytes() + b"".join(array.tobytes() for array in arrays)


def run(robot: Plant, pressures: np.ndarray) -> list[bytes]:
    return [bits(robot.step(row)) for row in pressures]


def hold(robot: Plant, pressures: np.ndarray, duration: float) -> PlantState:
    state = robot.state
    for _ in range(round(duration / robot.control_period)):
        state = robot.step(pressures)
    return state


def test_before_the_first_step_it_hangs_at_rest():
    state = plant().state
    assert state.time == 0.0
    assert np.abs(state.tip[:2]).max() < 0.03
    assert 0.65 < state.tip[2] < 0.72
    assert np.abs(state.pressures).max() < 600.0


def test_vented_it_stays_at_rest():
    robot = plant()
    before = robot.state
    after = hold(robot, np.zeros(9), 5.0)
    np.testing.assert_allclose(after.tip, before.tip, atol=1e-7)
    assert after.time == pytest.approx(5.0)


def test_same_seeds_give_the_same_bits():
    assert run(plant(), commands(200)) == run(plant(), commands(200))


def test_a_reset_gives_the_same_bits():
    robot = plant()
    first = [bits(robot.state), *run(robot, commands(200))]
    assert [bits(robot.reset()), *run(robot, commands(200))] == first


def test_another_process_gives_the_same_bits():
    digest = hashlib.sha256(b"".join(run(plant(), commands(100)))).hexdigest()
    script = (
        f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})\n"
        "import hashlib, test_plant as t\n"
        "print(hashlib.sha256(b''.join(t.run(t.plant(), t.commands(100)))).hexdigest())"
    )
    packages = [str(Path(package.__file__).parents[1]) for package in (bha_common, bha_sim)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(packages)}
    result = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert result.stdout.strip() == digest


def test_a_snapshot_continues_exactly_in_any_plant_of_the_robot():
    robot = plant()
    run(robot, commands(120))
    snapshot = pickle.loads(pickle.dumps(robot.save_state()))
    at, rest = bits(robot.state), run(robot, commands(120, seed=1))
    assert bits(robot.restore_state(snapshot)) == at
    assert run(robot, commands(120, seed=1)) == rest
    other = plant(seed=77)
    assert bits(other.restore_state(snapshot)) == at
    assert run(other, commands(120, seed=1)) == rest
    assert bits(other.reset()) == bits(plant().state)


def test_the_noise_has_a_seed_of_its_own():
    first, second = plant(seed=0), plant(seed=1)
    one, two = hold(first, np.full(9, 5e4), 1.0), hold(second, np.full(9, 5e4), 1.0)
    np.testing.assert_array_equal(one.true_lengths, two.true_lengths)
    assert not np.array_equal(one.lengths, two.lengths)
    first.reset(seed=1)
    assert bits(hold(first, np.full(9, 5e4), 1.0)) == bits(two)


def test_robots_differ():
    one, two = (hold(plant(robot), np.full(9, 5e4), 10.0) for robot in (0, 1))
    assert np.linalg.norm(one.tip - two.tip) > 0.005


def test_pressures_are_clipped():
    wild = np.array([-1e5, 2e5, 5e4, -1.0, MAX + 1, 0.0, 1e9, -1e9, MAX])
    assert run(plant(), np.tile(wild, (20, 1))) == run(
        plant(), np.tile(np.clip(wild, 0, MAX), (20, 1))
    )


@pytest.mark.parametrize(
    ("pressures", "message"),
    [
        (np.zeros(8), r"shape \(9,\)"),
        (np.zeros((9, 1)), r"shape \(9,\)"),
        (np.append(np.zeros(8), np.nan), "finite"),
        (np.append(np.zeros(8), np.inf), "finite"),
        (np.array([np.inf, -np.inf, 0, 0, 0, 0, 0, 0, 0]), "finite"),
    ],
)
def test_malformed_pressures_are_refused_and_change_nothing(pressures, message):
    robot, untouched = plant(), plant()
    with pytest.raises(ValueError, match=message):
        robot.step(pressures)
    assert run(robot, commands(20)) == run(untouched, commands(20))


@pytest.mark.parametrize("period", [0.0, -0.02, np.nan])
def test_a_control_period_must_be_positive(period):
    with pytest.raises(ValueError, match="control_period must be above 0"):
        plant(period=period)


def test_another_control_period_moves_alike():
    fine, coarse = plant(period=0.01), plant(period=0.05)
    pressures = MAX * np.random.default_rng(0).uniform(0.3, 0.7, 9)
    one, two = hold(fine, pressures, 15.0), hold(coarse, pressures, 15.0)
    assert two.time == pytest.approx(one.time)
    np.testing.assert_allclose(one.tip, two.tip, atol=1e-3)


def test_states_are_read_only():
    state = plant().step(np.zeros(9))
    for array in (state.lengths, state.pressures, state.tip, state.true_lengths):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
        assert array.base is None or not array.base.flags.writeable


def test_earlier_states_do_not_change():
    robot = plant()
    early = robot.step(np.full(9, 5e4))
    kept = bits(early)
    hold(robot, np.full(9, 5e4), 1.0)
    assert bits(early) == kept


def test_the_tip_is_near_constant_curvature():
    robot = plant()
    rng = np.random.default_rng(0)
    for _ in range(10):
        state = hold(robot, MAX * rng.uniform(0.25, 0.75, 9), 5.0)
        trunk = robot.parameters.trunk
        tip, rotation = tip_pose(state.true_lengths, trunk.bellows_radii, trunk.tool_length)
        assert np.linalg.norm(state.tip - tip) < 0.03
        assert np.linalg.norm(state.tip_quaternion) == pytest.approx(1.0)
        x, y, z, w = state.tip_quaternion
        axis = [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)]
        assert rotation[:, 2] @ axis > np.cos(np.radians(5.0))


def test_it_is_slow_and_remembers():
    robot = plant()
    rng = np.random.default_rng(3)
    hold(robot, MAX * rng.uniform(0.25, 0.75, 9), 30.0)
    pressures = MAX * rng.uniform(0.25, 0.75, 9)
    early = hold(robot, pressures, 5.0)
    late = hold(robot, pressures, 25.0)
    assert np.linalg.norm(early.tip - late.tip) > 0.005
    hold(robot, np.full(9, 0.9 * MAX), 20.0)
    again = hold(robot, pressures, 30.0)
    assert np.linalg.norm(again.tip - late.tip) > 0.005


@pytest.mark.parametrize("robot_seed", range(5))
def test_full_pressure_does_not_twist_the_trunk(robot_seed):
    robot = plant(robot_seed)
    hold(robot, np.full(9, MAX), 30.0)
    twists = [
        name
        for name in range(robot._mechanics.model.njnt)
        if "twist" in robot._mechanics.model.joint(name).name
    ]
    total = np.abs(robot._mechanics.data.qpos[twists]).sum()
    assert total < np.radians(3.0)


@pytest.fixture
def diverged(tmp_path, monkeypatch) -> Plant:
    # MuJoCo leaves a log file where it runs.
    monkeypatch.chdir(tmp_path)
    robot = plant()
    run(robot, commands(20))
    robot._mechanics.data.qvel[5] = np.nan
    with pytest.raises(PlantDivergedError, match=r"joints not finite: stretch_1_1.*mjWARN_BADQPOS"):
        run(robot, commands(20))
    return robot


def test_a_diverged_plant_says_so_until_it_is_reset(diverged):
    with pytest.raises(PlantDivergedError, match="reset or restore"):
        diverged.step(np.zeros(9))
    diverged.reset()
    assert run(diverged, commands(50)) == run(plant(), commands(50))


def test_a_diverged_plant_can_be_restored(diverged):
    source = plant()
    run(source, commands(30))
    diverged.restore_state(source.save_state())
    assert run(diverged, commands(30, seed=2)) == run(source, commands(30, seed=2))


def test_a_finite_explosion_is_noticed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    robot = plant()
    robot._mechanics.data.qvel[0] = 1e12
    with pytest.raises(PlantDivergedError, match="mjWARN_BADQ"):
        run(robot, commands(20))


def test_only_model_and_plant_need_mujoco():
    modules = ["potentiometers", "pneumatics", "visco_elasticity", "constant_curvature"]
    script = ";".join(
        [f"import bha_sim.{name}" for name in [*modules, "robot_parameters", "plant_state"]]
        + ["import sys", "print('mujoco' in sys.modules, 'rclpy' in sys.modules)"]
    )
    packages = [str(Path(package.__file__).parents[1]) for package in (bha_common, bha_sim)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(packages)}
    result = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True, check=True
    )
    assert result.stdout.split() == ["False", "False"]
