"""How stubborn a simulated robot is: settling, memory, ranges, reach, twist and speed.

A typical posture has each pressure drawn uniformly in the middle half of the range. `scale` makes a
measurement shorter, for a first look.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks.trunk.plant_drives import (
    Array,
    constant_curvature,
    control_lengths,
    hold,
    hold_all,
    range_ends,
    top,
    twist_angle,
    typical,
)
from benchmarks.trunk.tip_servo import TipServo
from bha_sim.plant import Plant

Figures = dict[str, Any]

CURVE_STEP = 0.2
"""Time between two values of the curves of settling [s]."""


def settling(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Time until the tip stays within 5 mm of where it is 40 s after a step of the pressures."""
    times, curves = [], []
    every = round(CURVE_STEP / plant.control_period)
    for _ in range(1 + max(2, round(24 * scale))):
        tips = np.array([state.tip for state in hold_all(plant, typical(plant, rng), 40.0)])
        distances = np.linalg.norm(tips - tips[-1], axis=1)
        off = np.flatnonzero(distances > 0.005)
        times.append((off.max(initial=-1) + 1) * plant.control_period)
        curves.append(distances[every - 1 :: every])
    # The first step begins at rest, vented: it is not typical.
    return {
        "median [s]": float(np.median(times[1:])),
        "p90 [s]": float(np.quantile(times[1:], 0.9)),
        "curve [m]": np.median(curves[1:], axis=0).tolist(),
    }


def repetition(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Distance of the tip from its mean when the same measured lengths are reached again.

    Each of 5 postures is reached 8 times, each time from another one, by integrating control on the
    measured lengths for 20 s; tip and lengths are averaged over the last second.
    """
    targets = []
    for _ in range(5):
        states = hold_all(plant, typical(plant, rng), 20.0)
        targets.append(np.mean([state.lengths for state in states[-50:]], axis=0))
    tips: list[list[Array]] = [[] for _ in targets]
    measured: list[list[Array]] = [[] for _ in targets]
    true: list[list[Array]] = [[] for _ in targets]
    pressures = typical(plant, rng)
    for _ in range(max(2, round(8 * scale))):
        for index in rng.permutation(len(targets)):
            hold(plant, typical(plant, rng), 10.0)
            states = control_lengths(plant, targets[index], pressures, 20.0)[-50:]
            tips[index].append(np.mean([state.tip for state in states], axis=0))
            measured[index].append(np.mean([state.lengths for state in states], axis=0))
            true[index].append(np.mean([state.true_lengths for state in states], axis=0))
    distances = [np.linalg.norm(np.array(one) - np.mean(one, axis=0), axis=1) for one in tips]
    return {
        "tip [m]": float(np.mean(distances)),
        "measured lengths [m]": float(np.mean([np.std(one, axis=0) for one in measured])),
        "true lengths [m]": float(np.mean([np.std(one, axis=0) for one in true])),
    }


def memory(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Where the tip is at the same pressures after 8 histories, 30 s after arrival."""
    diameters, distances = [], []
    for _ in range(max(1, round(6 * scale))):
        pressures = typical(plant, rng)
        tips = []
        for _ in range(8):
            hold(plant, rng.uniform(0.0, top(plant), 9), 20.0)
            tips.append(hold(plant, pressures, 30.0).tip)
        array = np.array(tips)
        diameters.append(np.linalg.norm(array[:, None] - array, axis=-1).max())
        distances.append(np.linalg.norm(array - array.mean(axis=0), axis=1).mean())
    return {
        "largest distance [m]": float(np.mean(diameters)),
        "distance from the mean [m]": float(np.mean(distances)),
    }


def ranges(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Find the ends of the range of each bellows, others at half pressure, and an hour later."""
    before = range_ends(plant)
    for _ in range(round(360 * scale)):
        hold(plant, rng.uniform(0.0, top(plant), 9), 10.0)
    return {
        "ends [m]": before.tolist(),
        "ends an hour later [m]": range_ends(plant).tolist(),
    }


def curvature(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Distance of the tip from constant-curvature kinematics on the true lengths."""
    distances = []
    for _ in range(max(2, round(60 * scale))):
        state = hold(plant, typical(plant, rng), 10.0)
        tip, _ = constant_curvature(plant, state)
        distances.append(np.linalg.norm(tip - state.tip))
    return {"mean [m]": float(np.mean(distances)), "largest [m]": float(np.max(distances))}


def reach(plant: Plant, goals: Array) -> Figures:
    """Error at each goal [m], shape (n, 3), that a servo with full knowledge comes to."""
    servo = TipServo(plant)
    hold(plant, servo.pressures, 20.0)
    errors = np.empty(len(goals))
    for index, goal in enumerate(goals):
        errors[index], _ = servo.reach(goal, patience=30.0, tolerance=0.008)
        if errors[index] > 0.010:
            servo.bend_towards(goal)
            retried, _ = servo.reach(goal, patience=60.0, tolerance=0.008)
            errors[index] = min(errors[index], retried)
    return {"errors [m]": errors.tolist()}


def twist(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Largest twist of the tip about the trunk's axis, under full pressure and in postures."""
    full = abs(twist_angle(plant, hold(plant, np.full(9, top(plant)), 60.0)))
    others = [
        abs(twist_angle(plant, hold(plant, rng.choice([0.0, top(plant)], 9), 10.0)))
        for _ in range(max(2, round(40 * scale)))
    ]
    return {"largest [rad]": float(max(full, *others))}


def speed(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Compare simulated with processor time for the bare step: the middle of 400 blocks.

    Processor time leaves out what others do on the core, but not that they slow it down.
    """
    blocks = []
    for _ in range(max(20, round(400 * scale))):
        pressures = typical(plant, rng)
        began = time.thread_time()
        for _ in range(25):
            plant.step(pressures)
        blocks.append(25 * plant.control_period / (time.thread_time() - began))
    return {"times real time, median": float(np.median(blocks))}
