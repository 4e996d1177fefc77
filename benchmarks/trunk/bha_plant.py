"""The simulated robot beside the real one: what it does, over many individual robots.

Every run is one measurement on one robot, fresh from its seed. The properties and their bounds are
in `benchmarks.trunk.plant_table`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.engine.experiment import Bound, Experiment, Figures, Run, Settings, Summary
from benchmarks.trunk import plant_properties, plant_sensors
from benchmarks.trunk.plant_drives import task_grid
from benchmarks.trunk.plant_figure import draw_properties
from benchmarks.trunk.plant_table import PROPERTIES, Robot
from bha_sim.plant import Plant
from bha_sim.robot_parameters import RobotParameters, draw_robot, load_parameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Measurement = Callable[[Plant, np.random.Generator, float], Figures]

_MEASUREMENTS: dict[str, Measurement] = {
    "settling": plant_properties.settling,
    "repetition": plant_properties.repetition,
    "repetition, ideal cables": plant_properties.repetition,
    "memory": plant_properties.memory,
    "ranges": plant_properties.ranges,
    "curvature": plant_properties.curvature,
    "twist": plant_properties.twist,
    "pneumatics": plant_sensors.pneumatics,
    "potentiometers": plant_sensors.potentiometers,
    "speed": plant_properties.speed,
}
_SHELLS = ("0.735", "0.78", "0.825")
_QUICK = 0.02


def plan(quick: bool) -> Sequence[Settings]:
    """Return every measurement; the task grid a shell each, since it takes longest."""
    scale = _QUICK if quick else 1.0
    names = ["draw", *(f"reach {radius}" for radius in _SHELLS), *_MEASUREMENTS]
    return [{"measurement": name, "scale": scale} for name in names]


def run(seed: int, *, measurement: str, scale: float) -> Figures:
    """Make one measurement on one robot."""
    kind = load_parameters()
    robot = draw_robot(kind, seed)
    if measurement == "draw":
        return _deviations(kind, robot)
    if measurement == "repetition, ideal cables":
        robot = replace(
            robot, potentiometers=replace(robot.potentiometers, play=0.0, drift_spread=0.0)
        )
    plant = Plant(robot, seed=seed)
    if measurement.startswith("reach "):
        grid = task_grid()
        shell = grid[np.isclose(np.linalg.norm(grid, axis=1), float(measurement.split()[1]))]
        goals = shell[:: max(1, round(1.0 / scale))]
        return {"goals [m]": goals.tolist(), **plant_properties.reach(plant, goals)}
    return _MEASUREMENTS[measurement](plant, np.random.default_rng(seed), scale)


def _deviations(kind: RobotParameters, robot: RobotParameters) -> Figures:
    """How far a robot's numbers are from those of its kind: the largest of each sort [-]."""
    pairs = {
        "stiffnesses": (robot.bellows.stiffness, kind.bellows.stiffness),
        "areas": (robot.bellows.areas, kind.bellows.areas),
        "friction": (robot.hysteresis.shares, kind.hysteresis.shares),
        "creep": (robot.relaxation.shares, kind.relaxation.shares),
        "masses": (
            np.append(robot.trunk.segment_masses, robot.trunk.tool_mass),
            np.append(kind.trunk.segment_masses, kind.trunk.tool_mass),
        ),
    }
    return {name: float(np.abs(own / mean - 1.0).max()) for name, (own, mean) in pairs.items()} | {
        "sensor offsets [m]": float(
            np.abs(robot.potentiometers.offsets - kind.potentiometers.offsets).max()
        )
    }


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every property, its mean and range over the robots."""
    full = all(run.settings["scale"] == 1.0 for run in runs)
    robots: dict[int, Robot] = {}
    for each in runs:
        robots.setdefault(each.seed, {})[each.settings["measurement"]] = each.figures
    rows, bounds = [], []
    for entry in PROPERTIES:
        values = np.array([entry.value(robot) for robot in robots.values()])
        rows.append(
            {
                "property": entry.name,
                "must be": entry.demand,
                "mean": float(values.mean()),
                "lowest robot": float(values.min()),
                "highest robot": float(values.max()),
                "robots within": f"{entry.within(values).sum()} of {len(values)}"
                if entry.bounded
                else "",
            }
        )
        if entry.bounded:
            bounds.append(
                _bound(entry.name, entry.low, entry.high, values.mean() if full else None)
            )
    return Summary(rows, bounds, _NOTE)


def _bound(name: str, low: float, high: float, measured: float | None) -> Bound:
    what = f"{name}, mean of the robots"
    if np.isinf(high):
        return Bound.at_least(what, low, measured)
    if np.isinf(low):
        return Bound.at_most(what, high, measured)
    return Bound.within(what, low, high, measured)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw settling, distances, ranges and reach of all robots."""
    draw_properties(runs, figure)


_NOTE = (
    "What spoils repetition are the cables of the potentiometers: their play and slow drift move "
    "the tip while the measured lengths stay; without both the same control repeats far better. "
    "Speed is simulated over processor time of the bare step, measured when the run was made: it "
    "needs a free core, since others take its cache. The numbers of the plant were chosen so that "
    "the whole moves as the article says of the real robot; it was not fitted to recordings of one."
)

EXPERIMENT = Experiment(
    name="bha-plant",
    claim="up to 20 s to settle, 5 mm of repetition accuracy, other postures at the same "
    "pressures, narrow ranges that differ and drift (section 4)",
    shows="the same of the simulated robot, over 10 individuals",
    minutes=12.0,
    seeds=10,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `bha-plant`."""
