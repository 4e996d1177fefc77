"""Without returning home, exploration drifts from solution to solution.

The drift of a joint is how far the answer to a goal moves after learning has settled: the root
mean square, over goals and joints, of g(x*) now less g(x*) then. Both reach the goals equally well.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.arm.compiled_reaching import compiled_babbler
from benchmarks.arm.configs import FAST
from benchmarks.arm.reaching import ReachingTask
from benchmarks.engine.experiment import (
    Bound,
    Experiment,
    Figures,
    Run,
    Settings,
    Summary,
    runs_with,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOVEMENTS = 40_000
_SETTLED = 4000  # movements after which drift is counted: before, answers still get smoother
_POINTS = 25
_EFFICIENCY = 0.3  # usual w_eff on these arms [m/rad]: without it the rate is multiplied by it

_WITHOUT_WEIGHTS = {"direction": "none", "efficiency": "none", "learning_rate": _EFFICIENCY}
_METHODS: dict[str, dict[str, Any]] = {
    "home and weights": {},
    "home, no weights": _WITHOUT_WEIGHTS,
    "weights, no home": {"home_probability": 0.0},
    "neither": {"home_probability": 0.0, **_WITHOUT_WEIGHTS},
}
_COLOURS = dict(zip(_METHODS, ("#0072b2", "#009e73", "#d55e00", "#cc79a7"), strict=True))


def plan(quick: bool) -> Sequence[Settings]:
    """Return every method."""
    movements = 200 if quick else _MOVEMENTS
    return [{"joints": 20, "method": method, "movements": movements} for method in _METHODS]


def run(seed: int, *, joints: int, method: str, movements: int) -> Figures:
    """Learn on and on, and look at the answers now and then."""
    task = ReachingTask(joints)
    babbler = compiled_babbler(task, dataclasses.replace(FAST, **_METHODS[method]), seed)
    settled = min(_SETTLED, movements // 2)
    babbler.run_movements(settled)
    before = babbler.inverse(task.goals)
    marks = np.unique(np.geomspace(settled, movements, _POINTS).astype(int))
    drifts, errors = [], []
    for mark in marks:
        babbler.run_movements(int(mark) - babbler.movements)
        postures = babbler.inverse(task.goals)
        drifts.append(np.sqrt(np.mean((postures - before) ** 2)))
        errors.append(task.errors_of(postures).mean())
    return {"movements": marks, "drifts": drifts, "errors": errors}


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every method."""
    rows, drift = [], {}
    for method in _METHODS:
        members = runs_with(runs, method=method)
        drifts = [run.figures["drifts"][-1] for run in members]
        drift[method] = median(drifts)
        rows.append(
            {
                "method": method,
                "movements": members[0].figures["movements"][-1],
                "drift, rms a joint, median [rad]": drift[method],
                "worst seed [rad]": max(drifts),
                "error, mean over goals, median [mm]": 1e3
                * median([run.figures["errors"][-1] for run in members]),
            }
        )
    long_enough = rows[0]["movements"] >= _MOVEMENTS
    ratio = drift["weights, no home"] / drift["home and weights"]
    bounds = [
        Bound.at_most(
            "drift with home and weights, median [rad]",
            0.2,
            drift["home and weights"] if long_enough else None,
        ),
        Bound.at_least(
            "drift without home over drift with home", 2.0, ratio if long_enough else None
        ),
    ]
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw drift and error over movements, the median of the seeds and their range."""
    left, right = figure.subplots(1, 2)
    for method, colour in _COLOURS.items():
        members = runs_with(runs, method=method)
        movements = members[0].figures["movements"]
        for axes, name, scale in ((left, "drifts", 1.0), (right, "errors", 1e3)):
            values = scale * np.array([run.figures[name] for run in members])
            axes.plot(movements, np.median(values, axis=0), color=colour, label=method)
            axes.fill_between(
                movements, values.min(axis=0), values.max(axis=0), color=colour, alpha=0.15
            )
    left.set(
        xlabel="movements",
        ylabel=f"drift since movement {movements[0]}, rms a joint [rad]",
        title="Answers drift without home",
    )
    right.set(
        xlabel="movements",
        ylabel="error, mean over goals [mm]",
        yscale="log",
        title="The error does not tell",
    )
    left.legend(fontsize="small")


_NOTE = (
    "The article gives no numbers. Without w_eff the learning rate is multiplied by its usual "
    "size, so that examples count as much as with it; then returning home is what decides, and the "
    "weights hardly matter."
)

EXPERIMENT = Experiment(
    name="drift",
    claim="without returning home, goal-directed exploration drifts between redundancy resolutions "
    "(section 3)",
    shows="joint drift over 40,000 movements with and without home, with and without weights",
    minutes=2.0,
    seeds=11,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `drift`."""
