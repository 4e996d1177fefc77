"""An arm with 20 joints unfolds: it reaches roughly everywhere soon, and later exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.arm.compiled_reaching import compiled_babbler
from benchmarks.arm.configs import ARTICLE, FAST, RLS
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
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.goal_babbler import GoalBabbler

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_JOINTS = 20
_STEPS = 25  # of a movement of the article; other methods are counted in these as well
_MARKS = (10, 100, 1_000, 10_000)  # movements
_CONFIGS = {
    "goal babbling": ARTICLE,
    "goal babbling, fast settings": FAST,
    "RLS goal babbling": RLS,
}


def plan(quick: bool) -> Sequence[Settings]:
    """Return every method."""
    marks = _MARKS[:2] if quick else _MARKS
    return [{"method": method, "movements": list(marks)} for method in _CONFIGS]


def run(seed: int, *, method: str, movements: list[int]) -> Figures:
    """Learn, and look at the answers to the goals at each mark.

    Returns
    -------
    dict
        Lists, an entry a mark: `mean`, `median` and `worst` error over the goals [m], and the
        `roughness` of the postures [rad].
    """
    task, config = ReachingTask(_JOINTS), _CONFIGS[method]
    # The loop in machine code knows local linear maps only.
    compiled = config.model == "local_linear_maps"
    babbler = compiled_babbler(task, config, seed) if compiled else task.babbler(config, seed)
    figures: dict[str, list[float]] = {"mean": [], "median": [], "worst": [], "roughness": []}
    for mark in movements:
        samples = _STEPS * mark - babbler.samples
        if isinstance(babbler, GoalBabbler):
            for _ in range(samples):
                action = babbler.ask()
                babbler.tell(action, task.arm.forward(action))
        else:
            babbler.run(samples)
        postures = babbler.inverse(task.goals)
        errors = task.errors_of(postures)
        figures["mean"].append(float(errors.mean()))
        figures["median"].append(float(np.median(errors)))
        figures["worst"].append(float(errors.max()))
        figures["roughness"].append(roughness(postures))
    return figures


def roughness(postures: FloatArray) -> float:
    """Return the root mean square difference of neighbouring joints [rad].

    An arm that bends evenly has 0. The first joint only turns the arm as a whole and is left out.

    Parameters
    ----------
    postures : Joint angles [rad], shape (G, m).
    """
    return math.sqrt(float(np.mean(np.diff(postures[:, 1:], axis=1) ** 2)))


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every method and number of movements."""
    rows: list[dict[str, Any]] = []
    for method in _CONFIGS:
        members = runs_with(runs, method=method)
        for index, mark in enumerate(members[0].settings["movements"] if members else []):
            row: dict[str, Any] = {"method": method, "movements": mark, "samples": _STEPS * mark}
            for name in ("mean", "median", "worst"):
                values = [1e3 * made.figures[name][index] for made in members]
                row[f"error over goals, {name} [mm]"] = median(values)
            row["roughness of postures [rad]"] = median(
                [made.figures["roughness"][index] for made in members]
            )
            rows.append(row)
    bounds = [
        Bound.at_most(
            f"{name} error of the best method after {_STEPS * mark:,} samples [mm]",
            limit,
            min(
                (row[f"error over goals, {name} [mm]"] for row in rows if row["movements"] == mark),
                default=None,
            ),
        )
        for name, mark, limit in (
            ("mean", 100, 15.0),
            ("mean", 10_000, 0.5),
            ("median", 10_000, 0.2),
        )
    ]
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw error and roughness over movements, the median of the seeds and their range."""
    left, right = figure.subplots(1, 2)
    for method in _CONFIGS:
        members = runs_with(runs, method=method)
        if not members:
            continue
        movements = members[0].settings["movements"]
        for axes, name, scale in ((left, "mean", 1e3), (right, "roughness", 1.0)):
            values = scale * np.array([made.figures[name] for made in members])
            (line,) = axes.plot(movements, np.median(values, axis=0), "o-", label=method)
            axes.fill_between(
                movements,
                values.min(axis=0),
                values.max(axis=0),
                color=line.get_color(),
                alpha=0.15,
            )
            axes.set_xscale("log")
    left.set(
        xlabel=f"movements of {_STEPS} samples",
        ylabel="error, mean over goals [mm]",
        yscale="log",
        title="An arm with 20 joints learns to reach",
    )
    right.set(
        xlabel=f"movements of {_STEPS} samples",
        ylabel="difference of neighbouring joints, rms [rad]",
        title="Roughness of its postures",
    )
    left.legend(fontsize="small")


_NOTE = (
    "Most of the mean error sits at the two goals at 0.94 m from the base, where the arm is nearly "
    "stretched; the median tells how the others fare."
)

EXPERIMENT = Experiment(
    name="unfold",
    claim="an arm with 20 joints reaches roughly everywhere after 100 movements, later to about "
    "1 mm, and its postures get smoother (figure 3)",
    shows="error and roughness of postures after 10 to 10,000 movements",
    minutes=10.0,
    seeds=11,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `unfold`."""
