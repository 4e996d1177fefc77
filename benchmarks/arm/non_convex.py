"""Where many actions reach a goal, fitting examples averages them; goal babbling does not.

The same model, local linear maps with the same gradient step, learns from random data and from
goal babbling's own data, with and without the weights of examples. Only the data differ.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.arm.compiled_reaching import compiled_babbler
from benchmarks.arm.configs import FAST
from benchmarks.arm.reaching import LIMIT, ReachingTask
from benchmarks.engine.experiment import (
    Bound,
    Experiment,
    Figures,
    Run,
    Settings,
    Summary,
    runs_with,
)
from bha_goal_babbling.local_linear_map import LocalLinearMaps

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The usual efficiency on these arms [m/rad]: without w_eff the rate is multiplied by it, so that
# examples count as much as before.
_EFFICIENCY = 0.3

_METHODS: dict[str, dict[str, Any]] = {
    "goal babbling": {},
    "goal babbling without w_dir": {"direction": "none"},
    "goal babbling without w_eff": {"efficiency": "none", "learning_rate": _EFFICIENCY},
    "goal babbling without weights": {
        "direction": "none",
        "efficiency": "none",
        "learning_rate": _EFFICIENCY,
    },
}
_DIRECT = "direct fit of random data"
_DIRECT_RATE = 0.05  # Large rates would follow single examples in place of their average.


def fit_random_data(joints: int, samples: int, rng: np.random.Generator) -> LocalLinearMaps:
    """Return maps fitted to postures drawn uniformly from all that there are, and their tips."""
    postures = rng.uniform(-LIMIT, LIMIT, (samples, joints))
    tips = ReachingTask(joints).arm.forward(postures)
    maps = LocalLinearMaps(FAST.map_distance, _DIRECT_RATE, tips[0], postures[0])
    for tip, posture in zip(tips, postures, strict=True):
        maps.learn(tip, posture, 1.0)
    return maps


def plan(quick: bool) -> Sequence[Settings]:
    """Return every method on arms of some joints."""
    movements = 100 if quick else 1000
    return [
        {"joints": joints, "method": method, "movements": movements}
        for joints in ((2,) if quick else (2, 5, 20))
        for method in (_DIRECT, *_METHODS)
    ]


def run(seed: int, *, joints: int, method: str, movements: int) -> Figures:
    """Learn by one method."""
    task = ReachingTask(joints)
    if method == _DIRECT:
        samples = movements * FAST.path_steps
        maps = fit_random_data(joints, samples, np.random.default_rng(seed))
        errors = task.errors(maps.predict_many)
    else:
        babbler = compiled_babbler(task, dataclasses.replace(FAST, **_METHODS[method]), seed)
        babbler.run_movements(movements)
        errors = task.errors(babbler.inverse)
    return {"mean_error": errors.mean(), "median_error": np.median(errors), "errors": errors}


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every method, a column for every arm."""
    arms = sorted({run.settings["joints"] for run in runs})
    methods = (_DIRECT, *_METHODS)
    found = {
        (joints, method): _errors(runs, joints, method) for joints in arms for method in methods
    }
    rows = [
        {
            "method": method,
            **{
                f"{joints} joints, mean (worst seed) [mm]": (
                    f"{median(found[joints, method]):.1f} ({max(found[joints, method]):.1f})"
                )
                for joints in arms
            },
        }
        for method in methods
    ]
    ours = max(median(found[joints, "goal babbling"]) for joints in arms)
    fitted = min(min(found[joints, _DIRECT]) for joints in arms)
    bounds = [
        Bound.at_least("direct fit of random data, mean error, best seed [mm]", 200, fitted),
        Bound.at_most("goal babbling, mean error, largest median [mm]", 20, ours),
    ]
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw the error of each goal by each method, on every arm."""
    arms = sorted({run.settings["joints"] for run in runs})
    methods = (_DIRECT, *_METHODS)
    for axes, joints in zip(
        np.atleast_1d(figure.subplots(1, len(arms), sharey=True)), arms, strict=True
    ):
        errors = [
            1e3
            * np.concatenate(
                [run.figures["errors"] for run in runs_with(runs, joints=joints, method=method)]
            )
            for method in methods
        ]
        axes.boxplot(errors, orientation="horizontal", whis=(5, 95), showfliers=False)
        axes.set_yticks(range(1, len(methods) + 1), methods)
        axes.set(xscale="log", xlabel="error of a goal [mm]", title=f"{joints} joints")
        axes.invert_yaxis()


def _errors(runs: Sequence[Run], joints: int, method: str) -> list[float]:
    """Return the mean error of every seed [mm]."""
    return [
        1e3 * run.figures["mean_error"] for run in runs_with(runs, joints=joints, method=method)
    ]


_NOTE = (
    "Fitting random data averages solutions on all sides and fails on every arm. Goal babbling's "
    "own data are consistent: its small noise and its returns home keep it on one solution. So "
    "much so that here the weights make no clear difference to the error, unlike what the article "
    "expects of them."
)

EXPERIMENT = Experiment(
    name="non-convex",
    claim="fitting an inverse to random data averages non-convex sets of solutions (section 1); "
    "goal-directed paths with the weights w_dir and w_eff resolve them (section 3)",
    shows="error of the same model fitted to random data and learned by goal babbling, with and "
    "without each weight",
    minutes=2.0,
    seeds=11,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `non-convex`."""
