"""How stubborn the simulated robot is: settling, memory, ranges, reach, twist and speed.

Run as ``python -m benchmarks.plant_properties --robots 3``. Every robot is drawn from its seed.
A typical posture has each pressure drawn uniformly in the middle half of the range.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.tip_servo import TipServo
from bha_sim.constant_curvature import tip_pose
from bha_sim.plant import Plant, PlantState
from bha_sim.robot_parameters import draw_robot, load_parameters

Array = NDArray[np.float64]
Figures = dict[str, float]


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=3, help="number of robots")
    parser.add_argument("--first", type=int, default=0, help="seed of the first robot")
    parser.add_argument("--only", nargs="*", choices=sorted(MEASUREMENTS), help="what to measure")
    arguments = parser.parse_args()
    for name in arguments.only or MEASUREMENTS:
        rows = []
        for seed in range(arguments.first, arguments.first + arguments.robots):
            began = time.perf_counter()
            plant = Plant(draw_robot(load_parameters(), seed), seed=seed)
            rows.append(MEASUREMENTS[name](plant, np.random.default_rng(seed)))
            rows[-1]["wall [s]"] = time.perf_counter() - began
        print(f"{name}:")
        for key in rows[0]:
            values = np.array([row[key] for row in rows])
            each = " ".join(f"{value:8.2f}" for value in values)
            print(f"  {key:<58} mean {values.mean():8.2f}   each {each}")


def settling(plant: Plant, rng: np.random.Generator) -> Figures:
    """Time until the tip stays within 5 mm of where it is 40 s after a step of the pressures."""
    times = []
    for _ in range(25):
        tips = np.array([state.tip for state in _hold_all(plant, _typical(plant, rng), 40.0)])
        off = np.linalg.norm(tips - tips[-1], axis=1) > 0.005
        times.append((np.flatnonzero(off).max(initial=-1) + 1) * plant.control_period)
    steps = times[1:]
    return {
        "settling to 5 mm, median [s]": float(np.median(steps)),
        "settling to 5 mm, 90th percentile [s]": float(np.quantile(steps, 0.9)),
    }


def repetition(plant: Plant, rng: np.random.Generator) -> Figures:
    """Distance of the tip from its mean when the same measured lengths are reached again.

    Each of 5 postures is reached 8 times, each time from another one, by integrating control on the
    measured lengths for 20 s; the tip is averaged over the last second.
    """
    targets = []
    for _ in range(5):
        states = _hold_all(plant, _typical(plant, rng), 20.0)
        targets.append(np.mean([state.lengths for state in states[-50:]], axis=0))
    lengths_errors, distances = [], []
    visits: list[list[Array]] = [[] for _ in targets]
    true: list[list[Array]] = [[] for _ in targets]
    pressures = _typical(plant, rng)
    for _ in range(8):
        for index in rng.permutation(len(targets)):
            _hold(plant, _typical(plant, rng), 10.0)
            states = _control_lengths(plant, targets[index], pressures, 20.0)[-50:]
            visits[index].append(np.mean([state.tip for state in states], axis=0))
            true[index].append(np.mean([state.true_lengths for state in states], axis=0))
            measured = np.mean([state.lengths for state in states], axis=0)
            lengths_errors.append(np.abs(measured - targets[index]).mean())
    spread = [np.std(lengths, axis=0).mean() for lengths in true]
    for tips in visits:
        distances += list(np.linalg.norm(np.array(tips) - np.mean(tips, axis=0), axis=1))
    return {
        "repetition accuracy of the tip, mean [mm]": 1e3 * float(np.mean(distances)),
        "error of the measured lengths [mm]": 1e3 * float(np.mean(lengths_errors)),
        "standard deviation of the true lengths [mm]": 1e3 * float(np.mean(spread)),
    }


def memory(plant: Plant, rng: np.random.Generator) -> Figures:
    """Where the tip is at the same pressures after different histories, 30 s after arrival."""
    diameters, distances = [], []
    for _ in range(6):
        pressures = _typical(plant, rng)
        tips = []
        for _ in range(8):
            _hold(plant, rng.uniform(0.0, _top(plant), 9), 20.0)
            tips.append(_hold(plant, pressures, 30.0).tip)
        array = np.array(tips)
        gaps = np.linalg.norm(array[:, None] - array, axis=-1)
        diameters.append(gaps.max())
        distances.append(np.linalg.norm(array - array.mean(axis=0), axis=1).mean())
    return {
        "largest distance of tips at equal pressures [mm]": 1e3 * float(np.mean(diameters)),
        "distance from their mean [mm]": 1e3 * float(np.mean(distances)),
    }


def ranges(plant: Plant, rng: np.random.Generator) -> Figures:
    """Find the ends of the range of each bellows, others at half pressure, and an hour later."""
    before = _range_ends(plant)
    for _ in range(360):
        _hold(plant, rng.uniform(0.0, _top(plant), 9), 10.0)
    after = _range_ends(plant)
    width = before[1] - before[0]
    moved = np.abs(after - before) / width
    return {
        "narrowest range [mm]": 1e3 * float(width.min()),
        "widest range [mm]": 1e3 * float(width.max()),
        "lowest end [mm]": 1e3 * float(before[0].min()),
        "highest lower end [mm]": 1e3 * float(before[0].max()),
        "lowest upper end [mm]": 1e3 * float(before[1].min()),
        "highest upper end [mm]": 1e3 * float(before[1].max()),
        "lower ends moved in an hour [% of range]": 1e2 * float(moved[0].mean()),
        "upper ends moved in an hour [% of range]": 1e2 * float(moved[1].mean()),
    }


def curvature(plant: Plant, rng: np.random.Generator) -> Figures:
    """Distance of the tip from constant-curvature kinematics on the true lengths."""
    distances = []
    for _ in range(60):
        state = _hold(plant, _typical(plant, rng), 10.0)
        tip, _ = _constant_curvature(plant, state)
        distances.append(np.linalg.norm(tip - state.tip))
    return {
        "distance from constant curvature, mean [mm]": 1e3 * float(np.mean(distances)),
        "the same, largest [mm]": 1e3 * float(np.max(distances)),
    }


def reach(plant: Plant, rng: np.random.Generator) -> Figures:
    """Share of the toolkit's task grid that a servo with full knowledge reaches within 10 mm."""
    servo = TipServo(plant)
    _hold(plant, servo.pressures, 20.0)
    grid = task_grid()
    errors = np.empty(len(grid))
    for index, goal in enumerate(grid):
        errors[index], _ = servo.reach(goal, patience=30.0, tolerance=0.008)
        if errors[index] > 0.010:
            servo.bend_towards(goal)
            retried, _ = servo.reach(goal, patience=60.0, tolerance=0.008)
            errors[index] = min(errors[index], retried)
    figures = {"task grid within 10 mm [%]": 1e2 * float(np.mean(errors < 0.010))}
    radii = np.linalg.norm(grid, axis=1)
    for radius in (0.735, 0.78, 0.825):
        shell = np.isclose(radii, radius)
        figures[f"  at r = {radius} m [%]"] = 1e2 * float(np.mean(errors[shell] < 0.010))
    figures["largest error [mm]"] = 1e3 * float(errors.max())
    return figures


def twist(plant: Plant, rng: np.random.Generator) -> Figures:
    """Largest twist of the tip about the trunk's axis, under full pressure and in postures."""
    full = abs(_twist(plant, _hold(plant, np.full(9, _top(plant)), 60.0)))
    others = [
        abs(_twist(plant, _hold(plant, rng.choice([0.0, _top(plant)], 9), 10.0))) for _ in range(40)
    ]
    return {
        "twist under full pressure [degrees]": float(np.degrees(full)),
        "largest twist with bellows empty or full [degrees]": float(np.degrees(max(others))),
    }


def speed(plant: Plant, rng: np.random.Generator) -> Figures:
    """Compare simulated time with the processor's time for the bare step."""
    pressures = [_typical(plant, rng) for _ in range(10)]
    # Time of the processor, so that other work on the machine does not count.
    began = time.process_time()
    for pressure in pressures:
        for _ in range(1000):
            plant.step(pressure)
    return {"times real time": 1e4 * plant.control_period / (time.process_time() - began)}


MEASUREMENTS: dict[str, Callable[[Plant, np.random.Generator], Figures]] = {
    "settling": settling,
    "repetition": repetition,
    "memory": memory,
    "ranges": ranges,
    "curvature": curvature,
    "reach": reach,
    "twist": twist,
    "speed": speed,
}


def task_grid() -> Array:
    """Goals of the CoR-Lab toolkit's task grid [m], shape (315, 3)."""
    goals = []
    for radius in (0.735, 0.78, 0.825):
        for polar in np.radians(np.linspace(5.14, 36.0, 7)):
            for azimuth in np.arange(15) * 2.0 * np.pi / 15.0:
                goals.append(
                    [
                        radius * np.sin(polar) * np.cos(azimuth),
                        radius * np.sin(polar) * np.sin(azimuth),
                        radius * np.cos(polar),
                    ]
                )
    return np.array(goals)


def _top(plant: Plant) -> float:
    return plant.parameters.pneumatics.max_pressure


def _typical(plant: Plant, rng: np.random.Generator) -> Array:
    return _top(plant) * rng.uniform(0.25, 0.75, 9)


def _hold(plant: Plant, pressures: Array, duration: float) -> PlantState:
    return _hold_all(plant, pressures, duration)[-1]


def _hold_all(plant: Plant, pressures: Array, duration: float) -> list[PlantState]:
    return [plant.step(pressures) for _ in range(round(duration / plant.control_period))]


def _control_lengths(
    plant: Plant, target: Array, pressures: Array, duration: float
) -> list[PlantState]:
    """Bring the measured lengths to a target by integrating control; the last states."""
    integral = pressures.copy()
    states = [plant.state]
    for _ in range(round(duration / plant.control_period)):
        error = target - states[-1].lengths
        integral += 1e6 * error * plant.control_period
        np.clip(integral, 0.0, _top(plant), out=integral)
        states.append(plant.step(integral + 3e5 * error))
    return states


def _range_ends(plant: Plant) -> Array:
    """Shortest and longest true length of each bellows [m], shape (2, 9)."""
    ends = np.empty((2, 9))
    for row, pressure in enumerate((0.0, _top(plant))):
        for index in range(9):
            pressures = np.full(9, 0.5 * _top(plant))
            pressures[index] = pressure
            ends[row, index] = _hold(plant, pressures, 10.0).true_lengths[index]
    return ends


def _constant_curvature(plant: Plant, state: PlantState) -> tuple[Array, Array]:
    trunk = plant.parameters.trunk
    return tip_pose(state.true_lengths, trunk.bellows_radii, trunk.tool_length)


def _twist(plant: Plant, state: PlantState) -> float:
    """Turn about its own axis of the tip against constant curvature [rad]."""
    x, y, z, w = state.tip_quaternion
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    relative = _constant_curvature(plant, state)[1].T @ turned
    return float(np.arctan2(relative[1, 0] - relative[0, 1], relative[0, 0] + relative[1, 1]))


if __name__ == "__main__":
    main()
