"""Where learning starts and returns to decides which of several solutions is learned."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING

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
from bha_goal_babbling.arrays import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_NAMES = {1: "up", -1: "down"}
_COLOURS = {1: "#0072b2", -1: "#d55e00"}


def side(postures: FloatArray) -> FloatArray:
    """Return the side to which postures, shape (G, m), bend: +1 up, -1 down; shape (G,).

    An arch above the line from base to tip bends clockwise: all joints but the first add up to a
    negative angle.
    """
    sides: FloatArray = -np.sign(postures[:, 1:].sum(axis=1))
    return sides


def plan(quick: bool) -> Sequence[Settings]:
    """Return arms of some joints with both homes."""
    movements = 100 if quick else 1000
    return [
        {"joints": joints, "branch": branch, "movements": movements}
        for joints in ((2,) if quick else (2, 5, 20))
        for branch in (1, -1)
    ]


def run(seed: int, *, joints: int, branch: int, movements: int) -> Figures:
    """Learn from one home."""
    task = ReachingTask(joints, branch)
    babbler = compiled_babbler(task, FAST, seed)
    babbler.run_movements(movements)
    postures = babbler.inverse(task.goals)
    errors = task.errors_of(postures)
    return {
        "mean_error": errors.mean(),
        "median_error": np.median(errors),
        "on_home_branch": np.mean(side(postures) == branch),
        "postures": postures,
    }


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every arm."""
    rows, on_branch, apart = [], [], []
    for joints in sorted({run.settings["joints"] for run in runs}):
        up, down = (runs_with(runs, joints=joints, branch=branch) for branch in (1, -1))
        distances = [
            float(np.sqrt(np.mean(np.subtract(a.figures["postures"], b.figures["postures"]) ** 2)))
            for a, b in zip(up, down, strict=True)
        ]
        shares = [run.figures["on_home_branch"] for run in up + down]
        on_branch.append(median(shares))
        apart.append(median(distances))
        rows.append(
            {
                "joints": joints,
                **{
                    f"error from home {_NAMES[branch]}, mean [mm]": 1e3
                    * median([run.figures["mean_error"] for run in members])
                    for branch, members in ((1, up), (-1, down))
                },
                "goals reached on home's branch, median [%]": 100 * on_branch[-1],
                "worst seed [%]": 100 * min(shares),
                "between both solutions, rms a joint [rad]": apart[-1],
            }
        )
    errors = [row[f"error from home {name}, mean [mm]"] for row in rows for name in _NAMES.values()]
    bounds = [
        Bound.at_least(
            "goals reached on home's branch, least median [%]", 95, 100 * min(on_branch)
        ),
        Bound.at_most("mean error, largest median [mm]", 20, max(errors)),
        Bound.at_least("between both solutions, least median [rad]", 0.2, min(apart)),
    ]
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw the postures for the same goals, learned from both homes."""
    shown = sorted({run.settings["joints"] for run in runs})[:2]
    for axes, joints in zip(np.atleast_1d(figure.subplots(1, len(shown))), shown, strict=True):
        goals = ReachingTask(joints).goals
        chosen = [
            int(np.argmin(np.linalg.norm(goals - at, axis=1))) for at in ([0.5, 0.4], [0.5, -0.4])
        ]
        for branch in (1, -1):
            first = runs_with(runs, joints=joints, branch=branch)[0]
            postures = np.array(first.figures["postures"])
            for number, index in enumerate(chosen):
                axes.plot(
                    *_links(postures[index]).T,
                    "o-",
                    color=_COLOURS[branch],
                    markersize=3,
                    label=f"learned from home {_NAMES[branch]}" if number == 0 else None,
                )
            axes.plot(
                *_links(ReachingTask(joints, branch).home_action).T, ":", color=_COLOURS[branch]
            )
        axes.plot([], [], ":", color="#444444", label="home")
        axes.plot(*goals[chosen].T, "x", color="black", label="goal")
        axes.set(title=f"{joints} joints", xlabel="x [m]", ylabel="y [m]", aspect="equal")
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)


def _links(posture: FloatArray) -> FloatArray:
    """Return base, joints and tip [m], shape (m + 1, 2)."""
    headings = np.cumsum(posture)
    steps = np.stack([np.cos(headings), np.sin(headings)], axis=1) / len(posture)
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


_NOTE = (
    "Same goals, same learner, same seeds: only home differs. With more joints there is no sharp "
    "border between branches; there the distance of the two solutions tells."
)

EXPERIMENT = Experiment(
    name="branches",
    claim="the starting and return point, together with the efficiency weighting, controls the "
    "redundancy resolution, which can be used to learn different solution branches (section 3)",
    shows="two inverse models for the same goals, from a home with the elbow up and one with it "
    "down",
    minutes=1.0,
    seeds=11,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `branches`."""
