"""Table `dimensions`: what learning to reach costs, over the number of joints.

The article's method appears twice, with its own settings and with faster ones, each the same for
all arms. A movement of RLS goal babbling is shorter than one of the article, so 25 of its samples
are counted as a movement.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.arm import configs
from benchmarks.arm.reaching import ReachingTask, time_to_reach
from benchmarks.engine.experiment import Bound, Experiment, Figures, Run, Settings, Summary

if TYPE_CHECKING:
    from matplotlib.figure import Figure

JOINTS = (2, 3, 5, 10, 20, 30, 50, 100, 200)
ARTICLE_JOINTS = tuple(joints for joints in JOINTS if joints <= 50)
SAMPLES_JOINTS = (2, 10, 20, 50)

MOVEMENT = 25
"""Samples in a movement of the article."""

MOST_MOVEMENTS = 1000
"""Movements after which a run counts as failed."""

ARTICLE, FAST, RLS = "goal babbling", "goal babbling, fast settings", "RLS goal babbling"

CONFIGS = {ARTICLE: configs.ARTICLE, FAST: configs.FAST, RLS: configs.RLS}


def plan(quick: bool) -> list[Settings]:
    """Return one run for every method and number of joints."""
    if quick:
        return [{"method": method, "joints": joints} for method in (FAST, RLS) for joints in (2, 5)]
    return [{"method": method, "joints": joints} for method in CONFIGS for joints in JOINTS]


def run(seed: int, *, method: str, joints: int) -> Figures:
    """Learn until the error is a tenth of the first one.

    Returns
    -------
    dict
        `samples` and `movements` that it took, None for a run that did not get there.
    """
    task = ReachingTask(joints)
    babbler = task.babbler(CONFIGS[method], seed)
    if method == RLS:
        samples = time_to_reach(
            task, babbler, most_samples=MOST_MOVEMENTS * MOVEMENT, every_sample=True
        ).samples
        movements = None if samples is None else samples / MOVEMENT
        return {"samples": samples, "movements": movements}
    needed = time_to_reach(task, babbler, most_movements=MOST_MOVEMENTS)
    return {"samples": needed.samples, "movements": needed.movements}


def summarise(runs: Sequence[Run]) -> Summary:
    """Return a row for every method and number of joints, and the bounds."""
    rows = []
    for method in CONFIGS:
        for joints in JOINTS:
            movements = _values(runs, method, joints, "movements")
            if not movements.size:
                continue
            samples = _values(runs, method, joints, "samples")
            rows.append(
                {
                    "method": method,
                    "joints": joints,
                    "movements, median": _quantile(movements, 0.5),
                    "movements, quartiles": _quartiles(movements),
                    "samples, median": _quantile(samples, 0.5),
                    "samples, quartiles": _quartiles(samples),
                    "not there": f"{np.isinf(movements).sum()} of {movements.size}",
                }
            )
    return Summary(rows, _bounds(runs), _NOTE)


_NOTE = (
    f"A movement of the article has {MOVEMENT} samples; {MOVEMENT} samples of RLS goal babbling "
    f"count as one. Runs end after {MOST_MOVEMENTS} movements. The error of RLS goal babbling is "
    "looked at after every sample, that of goal babbling at the ends of movements. The article "
    "gives no settings: those called its own are slow noise and a tenth of the gradient."
)


def _bounds(runs: Sequence[Run]) -> list[Bound]:
    attempts = _values(runs, RLS, None, "samples")
    failures = float(100 * np.isinf(attempts).mean()) if attempts.size else None
    return [
        Bound.at_most(
            f"largest median movements of {FAST}, 2 to 50 joints",
            60,
            _worst_median(runs, FAST, ARTICLE_JOINTS, "movements"),
        ),
        Bound.at_most(
            f"largest median movements of {RLS}, 2 to 50 joints",
            25,
            _worst_median(runs, RLS, ARTICLE_JOINTS, "movements"),
        ),
        Bound.at_most(
            f"largest median movements of {RLS}, 100 and 200 joints",
            60,
            _worst_median(runs, RLS, (100, 200), "movements"),
        ),
        Bound.at_most(
            f"largest median samples of {RLS}, 2, 10, 20 and 50 joints",
            120,
            _worst_median(runs, RLS, SAMPLES_JOINTS, "samples"),
        ),
        Bound.at_most(
            f"runs of {RLS} not there after {MOST_MOVEMENTS} movements, of 100", 1, failures
        ),
    ]


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw median and quartiles of the movements over the number of joints."""
    axes = figure.subplots()
    for color, method in enumerate(CONFIGS):
        found = [(m, _values(runs, method, m, "movements")) for m in JOINTS]
        joints = [m for m, values in found if values.size]
        if not joints:
            continue
        low, middle, high = (
            [_sorted_quantile(values, share) for _, values in found if values.size]
            for share in (0.25, 0.5, 0.75)
        )
        top = [min(value, MOST_MOVEMENTS) for value in high]
        axes.plot(joints, middle, "o-", color=f"C{color}", label=method)
        axes.fill_between(joints, low, top, color=f"C{color}", alpha=0.2, linewidth=0)
    axes.axhline(100, color="0.4", linestyle="--", label="the article: about 100")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xticks(JOINTS, [str(joints) for joints in JOINTS])
    axes.minorticks_off()
    axes.set_xlabel("joints of the arm")
    axes.set_ylabel(f"movements of {MOVEMENT} samples until the error\nis a tenth of the first one")
    axes.set_title("Learning to reach costs hardly more with many joints\n(median and quartiles)")
    axes.legend()


def _values(runs: Sequence[Run], method: str, joints: int | None, what: str) -> np.ndarray:
    """Return a figure of all runs of a method, infinite for those that did not get there."""
    chosen = [
        run.figures[what]
        for run in runs
        if run.settings["method"] == method and joints in (None, run.settings["joints"])
    ]
    return np.array([math.inf if value is None else value for value in chosen], dtype=np.float64)


def _sorted_quantile(values: np.ndarray, share: float) -> float:
    """Return a quantile; the mean of two values only where both are finite."""
    low, high = (float(np.quantile(values, share, method=method)) for method in ("lower", "higher"))
    return math.inf if math.isinf(high) else 0.5 * (low + high)


def _quantile(values: np.ndarray, share: float) -> float | None:
    value = _sorted_quantile(values, share)
    return None if math.isinf(value) else round(value, 1)


def _quartiles(values: np.ndarray) -> str:
    low, high = _quantile(values, 0.25), _quantile(values, 0.75)
    return " to ".join("never" if value is None else f"{value:g}" for value in (low, high))


def _worst_median(
    runs: Sequence[Run], method: str, joints: Sequence[int], what: str
) -> float | None:
    """Return the largest median over arms; None when one is missing, or half of a row failed."""
    medians: list[Any] = []
    for m in joints:
        values = _values(runs, method, m, what)
        medians.append(_quantile(values, 0.5) if values.size else None)
    return None if None in medians else max(medians)


EXPERIMENT = Experiment(
    name="dimensions",
    claim=(
        "Fig. 4b: the median cost to bring the error down to 10 % is about 100 movements, "
        "nearly the same from 2 to 50 joints."
    ),
    shows="movements and samples until the error is a tenth, from 2 to 200 joints",
    minutes=10.0,
    seeds=20,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
