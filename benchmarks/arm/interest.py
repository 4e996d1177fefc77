"""The table `interest`: whether it helps to choose goals by how learning goes at them.

Goal babbling on planar arms of 1 m, with goals drawn at random, by interest, or by SAGG-RIAC; all
else is the same. Random and interest-driven choice draw from the 77 goals at which the error is
measured, SAGG-RIAC from the box around them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.arm.configs import ARTICLE, FAST
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
from benchmarks.methods.goal_babbling import GoalBabbling
from benchmarks.methods.sagg_riac_paths import SaggRiacPaths
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.goal_paths import GoalPaths
from bha_goal_babbling.interest_choice import InterestGoalChoice
from bha_goal_babbling.target_source import TargetSource

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CHOICES: dict[str, Callable[[FloatArray, int, int], TargetSource]] = {
    "random": lambda goals, steps, seed: GoalPaths(goals, steps),
    "interest": lambda goals, steps, seed: GoalPaths(goals, steps, InterestGoalChoice(len(goals))),
    "SAGG-RIAC": lambda goals, steps, seed: SaggRiacPaths(
        goals.min(axis=0), goals.max(axis=0), steps, seed
    ),
}
"""Goal choices by name, each made from goals, shape (G, n), steps of a path, and a seed."""

LEARNERS = {"article": ARTICLE, "fast": FAST}
"""Settings of the learner by name: as in the article, and ours."""

_ARMS = (2, 20, 50)


def plan(quick: bool) -> Sequence[Settings]:
    """Return every choice with every learner on every arm."""
    joints = (2,) if quick else _ARMS
    movements = 30 if quick else 500
    return [
        {"choice": choice, "learner": learner, "joints": m, "movements": movements}
        for m in joints
        for learner in LEARNERS
        for choice in CHOICES
    ]


def run(seed: int, choice: str, learner: str, joints: int, movements: int) -> Figures:
    """Let one learner choose its goals.

    Returns
    -------
    The error [m] at first and after every movement, and the movements until it was at most a tenth
    of the first; None if it never was.
    """
    world = World.of_task(ReachingTask(joints))
    config = LEARNERS[learner]
    targets = CHOICES[choice](world.goals, config.path_steps, seed)
    babbling = GoalBabbling(world, np.random.default_rng(seed), config, targets)
    errors = [world.error(babbling.inverse(world.goals))]
    while babbling.movements < movements:
        babbling.step()
        if babbling.movements == len(errors):
            errors.append(world.error(babbling.inverse(world.goals)))
    there = np.flatnonzero(np.array(errors) <= 0.1 * errors[0])
    return {"errors": errors, "movements_to_tenth": int(there[0]) if there.size else None}


def summarise(runs: Sequence[Run]) -> Summary:
    """Return medians and quartiles over the seeds, and the choices against random."""
    rows = [
        _row(joints, learner, choice, chosen)
        for joints in sorted({run.settings["joints"] for run in runs})
        for learner in LEARNERS
        for choice in CHOICES
        if (chosen := runs_with(runs, joints=joints, learner=learner, choice=choice))
    ]
    return Summary(rows, _bounds(runs), _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw the errors over movements, an axis each arm and learner."""
    arms = sorted({run.settings["joints"] for run in runs})
    axes = figure.subplots(len(LEARNERS), len(arms), sharex=True, sharey=True, squeeze=False)
    for row, learner in zip(axes, LEARNERS, strict=True):
        for axis, joints in zip(row, arms, strict=True):
            for index, choice in enumerate(CHOICES):
                chosen = runs_with(runs, joints=joints, learner=learner, choice=choice)
                if not chosen:
                    continue
                errors = 1e3 * np.array([run.figures["errors"] for run in chosen])
                low, middle, high = np.quantile(errors, [0.25, 0.5, 0.75], axis=0)
                movements = np.arange(len(middle))
                axis.loglog(movements[1:], middle[1:], color=f"C{index}", label=choice)
                axis.fill_between(
                    movements[1:], low[1:], high[1:], color=f"C{index}", alpha=0.2, linewidth=0
                )
                axis.axhline(0.1 * middle[0], color="0.6", linewidth=0.8)
            axis.set_title(f"{joints} joints, settings: {learner}", fontsize=9)
        row[0].set_ylabel("error at the goals [mm]")
    for axis in axes[-1]:
        axis.set_xlabel("movements")
    axes[0, 0].legend(title="goals chosen by")
    figure.suptitle(
        "Goal choice: median and quartiles over seeds; the grey line is 10 % of the first error"
    )


def _quantile(runs: Sequence[Run], share: float) -> float | None:
    """Return a quantile of the movements to 10 %, never counting as infinity; None if infinite."""
    movements = [run.figures["movements_to_tenth"] for run in runs]
    numbers = np.array([math.inf if count is None else count for count in movements])
    # No interpolation: between a number and infinity there is nothing.
    value = float(np.quantile(numbers, share, method="higher"))
    return value if math.isfinite(value) else None


def _final(runs: Sequence[Run]) -> float:
    """Return the median of the last errors [m]."""
    return float(np.median([run.figures["errors"][-1] for run in runs]))


def _row(joints: int, learner: str, choice: str, runs: list[Run]) -> dict[str, Any]:
    movements = len(runs[0].figures["errors"]) - 1
    never = sum(run.figures["movements_to_tenth"] is None for run in runs)
    return {
        "joints": joints,
        "settings": learner,
        "goals chosen by": choice,
        "movements to 10 %": _quantile(runs, 0.5),
        "lower quartile": _quantile(runs, 0.25),
        "upper quartile": _quantile(runs, 0.75),
        "never": f"{never} of {len(runs)}",
        f"error after {movements} movements [mm]": round(1e3 * _final(runs), 1),
    }


def _bounds(runs: Sequence[Run]) -> list[Bound]:
    """Return that goals chosen by interest are no worse than random ones, all arms together."""
    return [
        Bound.at_most(
            f"settings {learner}: movements to 10 % with interest over those with random goals, "
            "geometric mean over the arms",
            1.0,
            _mean_ratio(runs, learner),
        )
        for learner in LEARNERS
    ]


def _mean_ratio(runs: Sequence[Run], learner: str) -> float | None:
    """Return interest over random, medians; None if one of them never gets there on some arm."""
    logarithms = []
    for joints in {run.settings["joints"] for run in runs}:
        chosen = _quantile(runs_with(runs, joints=joints, learner=learner, choice="interest"), 0.5)
        random = _quantile(runs_with(runs, joints=joints, learner=learner, choice="random"), 0.5)
        if chosen is None or random is None:
            return None
        logarithms.append(math.log(chosen / random))
    return math.exp(sum(logarithms) / len(logarithms))


_NOTE = (
    "The article gives no number. With 77 goals, learning is over before most of them were visited "
    "twice when the settings are fast, so there is little progress to choose by. SAGG-RIAC does "
    "not split its box before 100 goals: until then it draws from all of it."
)

EXPERIMENT = Experiment(
    name="interest",
    claim="goals can be chosen by predicted learning progress (section 3)",
    shows="movements to 10 % of the first error for random, interest-driven and SAGG-RIAC goals",
    minutes=12.0,
    seeds=20,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `interest`."""
