"""How stubborn the simulated robot is: settling, memory, ranges, reach, twist and speed.

Run as ``python -m benchmarks.plant_properties --robots 3``. Every robot is drawn from its seed.
A typical posture has each pressure drawn uniformly in the middle half of the range.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np

from benchmarks.plant_drives import (
    Array,
    constant_curvature,
    control_lengths,
    hold,
    hold_all,
    range_ends,
    task_grid,
    top,
    twist_angle,
    typical,
)
from benchmarks.tip_servo import TipServo
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters

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
        tips = np.array([state.tip for state in hold_all(plant, typical(plant, rng), 40.0)])
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
        states = hold_all(plant, typical(plant, rng), 20.0)
        targets.append(np.mean([state.lengths for state in states[-50:]], axis=0))
    lengths_errors, distances = [], []
    visits: list[list[Array]] = [[] for _ in targets]
    true: list[list[Array]] = [[] for _ in targets]
    pressures = typical(plant, rng)
    for _ in range(8):
        for index in rng.permutation(len(targets)):
            hold(plant, typical(plant, rng), 10.0)
            states = control_lengths(plant, targets[index], pressures, 20.0)[-50:]
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
        pressures = typical(plant, rng)
        tips = []
        for _ in range(8):
            hold(plant, rng.uniform(0.0, top(plant), 9), 20.0)
            tips.append(hold(plant, pressures, 30.0).tip)
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
    before = range_ends(plant)
    for _ in range(360):
        hold(plant, rng.uniform(0.0, top(plant), 9), 10.0)
    after = range_ends(plant)
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
        state = hold(plant, typical(plant, rng), 10.0)
        tip, _ = constant_curvature(plant, state)
        distances.append(np.linalg.norm(tip - state.tip))
    return {
        "distance from constant curvature, mean [mm]": 1e3 * float(np.mean(distances)),
        "the same, largest [mm]": 1e3 * float(np.max(distances)),
    }


def reach(plant: Plant, rng: np.random.Generator) -> Figures:
    """Share of the toolkit's task grid that a servo with full knowledge reaches within 10 mm."""
    servo = TipServo(plant)
    hold(plant, servo.pressures, 20.0)
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
    full = abs(twist_angle(plant, hold(plant, np.full(9, top(plant)), 60.0)))
    others = [
        abs(twist_angle(plant, hold(plant, rng.choice([0.0, top(plant)], 9), 10.0)))
        for _ in range(40)
    ]
    return {
        "twist under full pressure [degrees]": float(np.degrees(full)),
        "largest twist with bellows empty or full [degrees]": float(np.degrees(max(others))),
    }


def speed(plant: Plant, rng: np.random.Generator) -> Figures:
    """Compare simulated with wall time for the bare step: the fastest and the middle of blocks.

    The fastest block is that in which the machine did nothing else.
    """
    blocks = []
    for _ in range(400):
        pressures = typical(plant, rng)
        began = time.perf_counter()
        for _ in range(25):
            plant.step(pressures)
        blocks.append(25 * plant.control_period / (time.perf_counter() - began))
    return {
        "times real time, fastest block": float(np.max(blocks)),
        "times real time, median block": float(np.median(blocks)),
    }


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


if __name__ == "__main__":
    main()
