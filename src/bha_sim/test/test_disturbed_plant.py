"""Disturbances of a running plant: each does what it says, and goes without a trace."""

from __future__ import annotations

import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from bha_sim.disturbances import Disturbances
from bha_sim.plant import Plant
from bha_sim.plant_state import PlantState
from bha_sim.robot_parameters import RobotParameters, draw_robot, load_parameters

MAX = 1.3e5


def wrong(**values: Any) -> Disturbances:
    """Give disturbances what a user may give them."""
    return Disturbances(**values)


EACH: dict[str, Disturbances] = {
    "payload": Disturbances(payload=0.2),
    "softening": wrong(softening={"bellows_2_1": 0.3}),
    "leak": wrong(leak={"bellows_2_1": 0.3}),
    "sensor_shift": wrong(sensor_shift={"bellows_2_1": 0.005}),
    "sensor_drift": wrong(sensor_drift={"bellows_2_1": 1e-4}),
    "range_lost_below": wrong(range_lost_below=0.3),
    "range_lost_above": wrong(range_lost_above=0.3),
    "stuck_valves": wrong(stuck_valves={"bellows_2_1": True}),
}


def plant(robot: int = 0, seed: int = 0) -> Plant:
    return Plant(draw_robot(load_parameters(), robot), seed=seed)


def ideal(**trunk: float) -> RobotParameters:
    """A robot like the drawings, with sensors and valves without error and no memory."""
    parameters = load_parameters()
    return replace(
        parameters,
        trunk=replace(parameters.trunk, **trunk),
        bellows=replace(parameters.bellows, hardening=0.0),
        relaxation=replace(parameters.relaxation, shares=0.0 * parameters.relaxation.shares),
        hysteresis=replace(parameters.hysteresis, shares=0.0 * parameters.hysteresis.shares),
        pneumatics=replace(
            parameters.pneumatics, regulator_play=0.0, sensor_noise=0.0, sensor_resolution=0.0
        ),
        potentiometers=replace(
            parameters.potentiometers, noise=0.0, resolution=0.0, play=0.0, drift_spread=0.0
        ),
    )


def bits(state: PlantState) -> bytes:
    arrays = (state.lengths, state.pressures, state.tip, state.tip_quaternion, state.true_lengths)
    return np.float64(state.time).tobytes() + b"".join(array.tobytes() for array in arrays)


def run(robot: Plant, count: int = 50, seed: int = 0) -> list[bytes]:
    pressures = np.random.default_rng(seed).uniform(0.0, MAX, (count // 10 + 1, 9))
    return [bits(robot.step(row)) for row in pressures.repeat(10, axis=0)[:count]]


def hold(robot: Plant, pressure: float, duration: float) -> PlantState:
    for _ in range(round(duration / robot.control_period)):
        robot.step(np.full(9, pressure))
    return robot.state


def test_every_disturbance_is_looked_at():
    assert set(EACH) == set(Disturbances.__dataclass_fields__)


@pytest.mark.parametrize("name", EACH)
def test_it_begins_at_the_next_step_and_makes_a_difference(name):
    robot, sound = plant(), plant()
    run(robot), run(sound)
    robot.disturb(EACH[name])
    assert bits(robot.state) == bits(sound.state)
    assert robot.disturbances == EACH[name]
    assert run(robot, 100, seed=1) != run(sound, 100, seed=1)


@pytest.mark.parametrize("name", EACH)
def test_taken_back_it_leaves_a_sound_robot(name):
    """The state goes on from where it was, so both robots are brought to the same state."""
    robot, sound = plant(), plant()
    run(robot), run(sound)
    snapshot = sound.save_state()
    robot.disturb(EACH[name])
    run(robot, seed=1)
    robot.disturb(Disturbances())
    run(robot, seed=2)
    mechanics = robot.save_state().mechanics
    robot.restore_state(replace(snapshot, mechanics=mechanics))
    sound.restore_state(replace(snapshot, mechanics=mechanics))
    assert run(robot, seed=3) == run(sound, seed=3)


def test_without_disturbances_nothing_is_different():
    robot, sound = plant(), plant()
    robot.disturb(Disturbances())
    first, second = run(robot), run(sound)
    robot.disturb(Disturbances())
    assert [*first, *run(robot, seed=1)] == [*second, *run(sound, seed=1)]


@pytest.mark.parametrize("name", EACH)
def test_a_snapshot_goes_on_exactly_in_a_plant_that_never_heard_of_it(name):
    robot, other = plant(), plant(seed=5)
    robot.disturb(EACH[name])
    run(robot)
    snapshot = pickle.loads(pickle.dumps(robot.save_state()))
    later = run(robot, seed=1)
    other.restore_state(snapshot)
    assert other.disturbances == EACH[name]
    assert run(other, seed=1) == later


@pytest.mark.parametrize("name", EACH)
def test_a_reset_keeps_what_is_wrong(name):
    robot, fresh = plant(), plant()
    robot.disturb(EACH[name])
    run(robot)
    robot.reset()
    fresh.disturb(EACH[name])
    assert robot.disturbances == EACH[name]
    assert run(robot) == run(fresh)


def test_the_robot_s_own_parameters_stay():
    robot = plant()
    before = pickle.dumps(robot.parameters)
    robot.disturb(wrong(payload=0.5, softening=0.5))
    run(robot)
    assert pickle.dumps(robot.parameters) == before


def test_a_payload_hangs_on_the_bellows():
    """Vented and upright, every bellows stretches by its third of the weight over its stiffness."""
    robot = Plant(ideal(), seed=0)
    before = robot.state.true_lengths
    robot.disturb(Disturbances(payload=0.3))
    after = hold(robot, 0.0, 30.0).true_lengths
    np.testing.assert_allclose(after - before, 0.3 * 9.81 / (3 * 540.0), rtol=1e-6)


def test_a_payload_has_inertia():
    """Without weight a first push of the pressures moves a loaded tip more slowly."""
    robots = [Plant(ideal(gravity=0.0), seed=0) for _ in range(2)]
    robots[1].disturb(Disturbances(payload=1.0))
    push = np.zeros(9)
    push[6] = MAX
    for robot in robots:
        for _ in range(15):
            robot.step(push)
    light, loaded = (np.linalg.norm(robot.state.tip[:2]) for robot in robots)
    assert loaded < 0.5 * light
    # And a step changes nothing of the mass that MuJoCo knows: discs, tool and payload.
    model = robots[1]._mechanics.model
    assert model.body_subtreemass[1] == pytest.approx(0.70 + 0.55 + 0.40 + 0.15 + 1.0)


def test_a_softened_bellows_stretches_by_what_its_stiffness_says():
    robot = Plant(ideal(gravity=0.0), seed=0)
    robot.disturb(wrong(softening=[0.0, 0.5, 0.2]))
    extension = hold(robot, 2e4, 60.0).true_lengths - 0.15
    expected = 2e4 * 1e-3 / (540.0 * np.array([1.0, 0.5, 0.8]))
    np.testing.assert_allclose(extension, expected.repeat(3), rtol=1e-6)


def test_a_leak_lowers_the_pressure():
    robot = Plant(ideal(), seed=0)
    robot.disturb(wrong(leak=[0.25, 0.0, 4.0]))
    pressures = hold(robot, 5e4, 20.0).pressures
    np.testing.assert_allclose(pressures, np.repeat([4e4, 5e4, 1e4], 3), rtol=1e-9)


def test_a_leak_is_faster_by_what_it_lets_out():
    robot = Plant(ideal(), seed=0)
    robot.disturb(wrong(leak=1.0))
    waiting = round(robot.parameters.pneumatics.dead_time / robot.control_period)
    pressures = [robot.step(np.full(9, 1e5)).pressures[0] for _ in range(waiting + 40)][waiting:]
    elapsed = robot.control_period * np.arange(1, 41)
    expected = 5e4 * (1.0 - np.exp(-2.0 * elapsed / 0.25))
    np.testing.assert_allclose(pressures, expected, rtol=1e-9)


def test_a_shift_is_in_the_reading_alone():
    robot = Plant(ideal(), seed=0)
    robot.disturb(wrong(sensor_shift={"bellows_1_3": -0.004}))
    state = hold(robot, 5e4, 1.0)
    error = np.zeros(9)
    error[2] = -0.004
    np.testing.assert_allclose(state.lengths - state.true_lengths, error, atol=1e-12)


def test_a_drift_begins_when_it_is_set_and_ends_when_it_is_taken_back():
    robot = Plant(ideal(), seed=0)
    hold(robot, 5e4, 1.0)
    robot.disturb(wrong(sensor_drift={"bellows_1_1": 1e-4, "bellows_1_2": 2e-4}))
    state = hold(robot, 5e4, 10.0)
    np.testing.assert_allclose((state.lengths - state.true_lengths)[:3], [1e-3, 2e-3, 0.0])
    # Another speed goes on from where the reading is; without one it comes back.
    robot.disturb(wrong(sensor_drift={"bellows_1_1": -1e-4}))
    state = hold(robot, 5e4, 5.0)
    np.testing.assert_allclose(
        (state.lengths - state.true_lengths)[:3], [5e-4, 0.0, 0.0], atol=1e-12
    )


def test_lost_ranges_clip_the_pressures_at_both_ends():
    robot = Plant(ideal(), seed=0)
    robot.disturb(wrong(range_lost_below=0.2, range_lost_above={"bellows_1_1": 0.4}))
    low, high = hold(robot, 0.0, 20.0).pressures, hold(robot, MAX, 20.0).pressures
    np.testing.assert_allclose(low, 0.2 * MAX, rtol=1e-6)
    np.testing.assert_allclose(high, [0.6 * MAX] + [MAX] * 8, rtol=1e-6)


def test_a_stuck_valve_holds_until_it_lets_go():
    robot = Plant(ideal(), seed=0)
    hold(robot, 5e4, 20.0)
    robot.disturb(wrong(stuck_valves={"bellows_3_1": True}))
    pressures = hold(robot, 9e4, 20.0).pressures
    np.testing.assert_allclose(pressures, [9e4] * 6 + [5e4] + [9e4] * 2, rtol=1e-6)
    robot.disturb(Disturbances())
    np.testing.assert_allclose(hold(robot, 9e4, 20.0).pressures, 9e4, rtol=1e-6)


@pytest.mark.parametrize("robot_seed", range(2))
def test_the_worst_of_everything_at_once_does_not_diverge(robot_seed):
    robot = plant(robot_seed)
    for softening in (0.5, {"bellows_1_1": 0.5, "bellows_2_3": 0.5, "bellows_3_2": 0.5}):
        robot.disturb(wrong(payload=1.0, softening=softening))
        run(robot, 500, seed=robot_seed)
        hold(robot, MAX, 10.0)
        assert np.isfinite(robot.state.tip).all()
        robot.disturb(Disturbances())
        run(robot, 100, seed=robot_seed)
