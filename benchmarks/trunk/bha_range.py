"""Something goes wrong with a trunk that has learned: the error then, and as learning goes on."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.engine.experiment import (
    Bound,
    Experiment,
    Figures,
    Run,
    Settings,
    Summary,
    runs_with,
)
from benchmarks.trunk.bha_runs import (
    draw_spread,
    errors,
    frozen_errors,
    held_out,
    learned_by,
    task_of,
)
from bha_bringup.in_process import InProcessRobot
from bha_common import bellows
from bha_sim.disturbances import Disturbances

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEARNED = 45.0  # [min] of exploration before
_AFTER = [5.0, 10.0, 15.0]  # [min] of exploration since
_GOALS = 16

DISTURBANCES: dict[str, tuple[str, float, int]] = {
    "nothing": ("payload", 0.0, 0),
    "weak bellows": ("softening", 0.3, 1),
    "leak": ("leak", 0.5, 1),
    "payload": ("payload", 0.2, 0),
    "shifted potentiometer": ("sensor_shift", 0.010, 1),
    "drifting potentiometer": ("sensor_drift", 1e-5, 1),
    "narrowed ranges": ("range_lost_above", 0.15, 3),
    "stuck valve": ("stuck_valves", 1.0, 1),
}
"""What goes wrong: the field of `Disturbances`, its value, and on how many bellows."""


def plan(quick: bool) -> Sequence[Settings]:
    """Return every disturbance."""
    learned, after, goals = (1.0, [1.0], 2) if quick else (_LEARNED, _AFTER, _GOALS)
    names = ("nothing", "payload") if quick else DISTURBANCES
    return [
        {"disturbance": name, "learned": learned, "after": after, "goals": goals} for name in names
    ]


def disturbances(name: str, rng: np.random.Generator) -> Disturbances:
    """Return what is meant by one of `DISTURBANCES`, on bellows drawn at random."""
    field, value, count = DISTURBANCES[name]
    given: Any = True if field == "stuck_valves" else value
    what: dict[str, Any] = {field: given}
    if not count:
        return Disturbances(**what)
    chosen = rng.choice(bellows.NAMES, count, replace=False)
    what[field] = {str(each): given for each in chosen}
    return Disturbances(**what)


def paused(wrong: Disturbances, drifted: float) -> Disturbances:
    """Return what is wrong after drifts of some time [s], and drifts no further."""
    shift = np.array(wrong.sensor_shift) + drifted * np.array(wrong.sensor_drift)
    return dataclasses.replace(wrong, sensor_shift=tuple(shift), sensor_drift=0.0)


def run(seed: int, *, disturbance: str, learned: float, after: list[float], goals: int) -> Figures:
    """Let a robot learn, disturb it, and let it learn on; what it knew before stands beside it.

    A drift waits while errors are measured: that takes ten minutes, half of which the learner does
    not see.
    """
    task = task_of("2d")
    robot = InProcessRobot(task, seed=seed)
    robot.identify(20 if learned < 5.0 else None)
    robot.babble(60.0 * learned)
    targets = held_out(task, seed, goals)
    before = errors(robot, targets).mean()
    frozen = learned_by(robot)
    wrong = disturbances(disturbance, np.random.default_rng([seed, 3]))
    drifted = explored = 0.0
    robot.plant.disturb(paused(wrong, drifted))
    learning = [errors(robot, targets).mean()]
    without = [learning[0]]
    for minute in after:
        begin = robot.time
        robot.plant.disturb(
            dataclasses.replace(paused(wrong, drifted), sensor_drift=wrong.sensor_drift)
        )
        robot.babble(60.0 * (minute - explored))
        explored = minute
        drifted += robot.time - begin
        robot.plant.disturb(paused(wrong, drifted))
        learning.append(errors(robot, targets).mean())
        without.append(frozen_errors(robot, targets, frozen).mean())
    return {
        "minutes": [0.0, *after],
        "before [m]": before,
        "learning [m]": learning,
        "frozen [m]": without,
    }


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every disturbance."""
    rows, bounds = [], []
    for name in DISTURBANCES:
        members = runs_with(runs, disturbance=name)
        if not members:
            continue
        before = 1e3 * np.array([run.figures["before [m]"] for run in members])
        learning, frozen = (
            1e3 * np.array([run.figures[key] for run in members])
            for key in ("learning [m]", "frozen [m]")
        )
        minutes = members[0].figures["minutes"]
        row: dict[str, Any] = {
            "what happens": name,
            "before [mm]": float(before.mean()),
            "right after [mm]": float(learning[:, 0].mean()),
        }
        for index, minute in enumerate(minutes[1:], start=1):
            row[f"{minute:g} min later [mm]"] = float(learning[:, index].mean())
        row["frozen, at the end [mm]"] = float(frozen[:, -1].mean())
        row["at the end over before"] = float(learning[:, -1].mean() / before.mean())
        rows.append(row)
        full = minutes[-1] == _AFTER[-1]
        bounds.append(
            Bound.at_most(
                f"{name}: error {_AFTER[-1]:g} min later over the one before, means of the robots",
                1.3,
                row["at the end over before"] if full else None,
            )
        )
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw the errors over the minutes since, an axis for every disturbance."""
    names = [name for name in DISTURBANCES if runs_with(runs, disturbance=name)]
    columns = min(4, len(names))
    grid = figure.subplots(-(-len(names) // columns), columns, sharex=True, squeeze=False)
    for axes, name in zip(grid.ravel(), names, strict=False):
        members = runs_with(runs, disturbance=name)
        minutes = members[0].figures["minutes"]
        for key, colour in (("frozen [m]", "#d55e00"), ("learning [m]", "#0072b2")):
            values = 1e3 * np.array([run.figures[key] for run in members])
            draw_spread(axes, minutes, values, colour, key[:-4])
        axes.axhline(1e3 * np.mean([run.figures["before [m]"] for run in members]), color="0.6")
        axes.set(title=name, ylim=(0.0, None))
    for axes in grid[-1]:
        axes.set_xlabel("minutes since [min]")
    for axes in grid[:, 0]:
        axes.set_ylabel("error [mm]")
    grid[0, 0].legend(fontsize="small")


_NOTE = (
    f"Robots that have learned the task 2d for {_LEARNED:g} minutes. The lengths are controlled, "
    "so that weak bellows, leaks and payloads change little for the learner unless they take a "
    "bellows to an end of its range; a potentiometer that errs changes everything. Which bellows "
    "is concerned is drawn for every robot. The potentiometer that drifts by 0.6 mm a minute rests "
    "while errors are measured: half of that time the frozen model is asked, and the learner sees "
    "nothing. The frozen model answers every goal by what was known before, offsets included. The "
    "grey line is the error before."
)

EXPERIMENT = Experiment(
    name="bha-range",
    claim="ranges change, sensors drift, and learning rediscovers (section 4)",
    shows="error before something goes wrong, right after, and as learning goes on, with a frozen "
    "model beside it",
    minutes=60.0,
    seeds=10,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `bha-range`."""
