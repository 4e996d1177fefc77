"""An arm of two joints learns to control the height of its tip: goal babbling that can be seen."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.engine.experiment import Bound, Experiment, Figures, Run, Settings, Summary
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ARM = PlanarArm(2)
_GOALS = np.linspace(-0.9, 0.9, 19)[:, np.newaxis]  # heights [m]
_HOME = np.zeros(2)
_SNAPSHOTS = (10, 40, 200, 3000)  # movements
_CELL = 0.1  # side of the cells of which the action space consists [rad]
# White noise and a low rate: with fewer directions tried, the first that brings something wins.
_CONFIG = GoalBabblerConfig(
    map_distance=0.2, learning_rate=0.03, noise_spread=0.05, noise_step=0.15
)


def height(angles: FloatArray) -> FloatArray:
    """Return the height of the tip [m], shape (1,) or (N, 1), of angles [rad], (2,) or (N, 2)."""
    return _ARM.forward(angles)[..., 1:]


def visited_share(actions: FloatArray, cell: float) -> float:
    """Return the share of the cells of the square +-pi that actions, shape (N, 2), fell into."""
    sides = round(2 * math.pi / cell)
    indices = np.floor((actions + math.pi) / (2 * math.pi) * sides).astype(int)
    return len(np.unique(np.clip(indices, 0, sides - 1), axis=0)) / sides**2


def angle_between(first: FloatArray, second: FloatArray) -> float:
    """Return the angle of two lines through the origin [degrees], 0 to 90, of vectors (2,)."""
    cosine = abs(first @ second) / (np.linalg.norm(first) * np.linalg.norm(second))
    return math.degrees(math.acos(min(1.0, float(cosine))))


def plan(quick: bool) -> Sequence[Settings]:
    """Return the one setting."""
    return [{"snapshots": list(_SNAPSHOTS[:3] if quick else _SNAPSHOTS)}]


def run(seed: int, *, snapshots: Sequence[int]) -> Figures:
    """Learn, and look at the inverse estimate now and then."""
    limits = np.full(2, math.pi)
    rng = np.random.default_rng(seed)
    babbler = GoalBabbler(_CONFIG, _GOALS, _HOME, height(_HOME), -limits, limits, rng)
    actions: list[FloatArray] = []
    taken = []
    for movements in snapshots:
        while babbler.movements < movements:
            action = babbler.ask()
            babbler.tell(action, height(action))
            actions.append(action)
        estimate = babbler.inverse(_GOALS)
        taken.append(
            {
                "movements": movements,
                "samples": len(actions),
                "visited": visited_share(np.array(actions), _CELL),
                "mean_error": np.abs(height(estimate) - _GOALS).mean(),
                "off_gradient": angle_between(estimate[-1] - estimate[0], _ARM.jacobian(_HOME)[1]),
                "estimate": estimate,
                # Few enough to store, evenly from all the way so far.
                "actions": np.round(actions[:: max(1, len(actions) // 500)], 4),
            }
        )
    return {"snapshots": taken}


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every snapshot."""
    rows = []
    for number, snapshot in enumerate(runs[0].figures["snapshots"]):
        members = [run.figures["snapshots"][number] for run in runs]
        rows.append(
            {
                "movements": snapshot["movements"],
                "error, mean over goals, median [mm]": 1e3 * median(_each(members, "mean_error")),
                "worst seed [mm]": 1e3 * max(_each(members, "mean_error")),
                "action space visited, median [%]": 100 * median(_each(members, "visited")),
                "off the steepest gradient, median [deg]": median(_each(members, "off_gradient")),
            }
        )
    finals = [run.figures["snapshots"][-1] for run in runs]
    long_enough = rows[-1]["movements"] >= _SNAPSHOTS[-1]
    final_error = 1e3 * median(_each(finals, "mean_error"))
    spreading = median(_each([run.figures["snapshots"][1] for run in runs], "off_gradient"))
    bounds = [
        Bound.at_most(
            "final error, mean over goals, median [mm]", 10.0, final_error if long_enough else None
        ),
        Bound.at_most(
            "action space visited, worst seed [%]", 10.0, 100 * max(_each(finals, "visited"))
        ),
        Bound.at_most("off the steepest gradient while it spreads, median [deg]", 15.0, spreading),
    ]
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw the first run: examples and estimate in the plane of both joints, height as colour."""
    snapshots = runs[0].figures["snapshots"]
    figure.set_size_inches(3.2 * len(snapshots) + 1.0, 3.8)
    axis = np.linspace(-math.pi, math.pi, 121)
    first, second = np.meshgrid(axis, axis)
    heights = height(np.stack([first.ravel(), second.ravel()], axis=1)).reshape(first.shape)
    panels = np.atleast_1d(figure.subplots(1, len(snapshots), sharey=True))
    for axes, snapshot in zip(panels, snapshots, strict=True):
        colours = axes.contourf(first, second, heights, levels=20, cmap="coolwarm", alpha=0.7)
        axes.plot(
            *np.array(snapshot["actions"]).T, ".", color="#007a33", markersize=2, label="examples"
        )
        axes.plot(*np.array(snapshot["estimate"]).T, ".-", color="black", label="inverse estimate")
        error = 1e3 * snapshot["mean_error"]
        axes.set(
            title=f"{snapshot['movements']} movements: {error:.0f} mm",
            xlabel="joint 1 [rad]",
            aspect="equal",
        )
    panels[0].set_ylabel("joint 2 [rad]")
    panels[0].legend(fontsize="small", loc="lower left")
    figure.colorbar(colours, ax=list(panels), label="height of the tip [m]", shrink=0.8)


def _each(members: Sequence[Figures], name: str) -> list[float]:
    return [member[name] for member in members]


_NOTE = (
    "The article shows pictures, no numbers. Home is the stretched arm; the steepest gradient "
    "there turns joint 1 twice as far as joint 2. The angle is that between the line through both "
    "ends of the estimate and this gradient; tuning bends the estimate, because far from home the "
    "gradient points elsewhere. Visited are cells of 0.1 rad of the square +-pi."
)

EXPERIMENT = Experiment(
    name="toy",
    claim="a 2-joint arm controls the height of its tip: the estimate starts at home, spreads "
    "along the steepest gradient and is then tuned; the data cover a thin sheet of the action "
    "space (figure 2)",
    shows="four snapshots, the share of the action space visited, the final error",
    minutes=3.0,
    seeds=20,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `toy`."""
