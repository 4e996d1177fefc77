"""A trunk in use: goals that a user sends teach nothing, what sensors are off by, or everything."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

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
from benchmarks.trunk.bha_runs import draw_spread, errors, held_out, task_of
from bha_bringup.in_process import InProcessRobot
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_sim.disturbances import Disturbances

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LEARNED = 30.0  # [min] of exploration before
_BLOCKS, _BLOCK = 6, 25
_CASES = ("sound robot", "potentiometer shifted by 10 mm")
_COLOURS = {"everything": "#0072b2", "offsets": "#009e73", "nothing": "#d55e00"}
_LABELS = {
    "everything": "learns everything",
    "offsets": "follows offsets of sensors",
    "nothing": "learns nothing",
}
_LIMITS = {"everything": (1.0, 0.8), "offsets": (1.0, 1.0)}  # of errors, for each of the cases


def plan(quick: bool) -> Sequence[Settings]:
    """Return a sound and a changed robot, with each of what use may teach."""
    size = {"learned": 1.0, "blocks": 2, "block": 2} if quick else _full()
    return [{"case": case, "learns": learns, **size} for case in _CASES for learns in _LABELS]


def _full() -> Settings:
    return {"learned": _LEARNED, "blocks": _BLOCKS, "block": _BLOCK}


def run(seed: int, *, case: str, learns: str, learned: float, blocks: int, block: int) -> Figures:
    """Let a robot explore, then send it to goals, each a new one."""
    task = task_of("2d")
    robot = InProcessRobot(
        task, seed=seed, learner_settings=LearnerSettings(seed=seed, learn_in_use=learns)
    )
    robot.identify(20 if learned < 5.0 else None)
    robot.babble(60.0 * learned)
    if case == _CASES[1]:
        shift = np.zeros(9)
        shift[np.random.default_rng([seed, 3]).integers(9)] = 0.010
        robot.plant.disturb(Disturbances(sensor_shift=tuple(shift.tolist())))
    goals = held_out(task, seed, blocks * block)
    start = robot.time
    means, minutes = [], []
    for first in range(0, len(goals), block):
        means.append(errors(robot, goals[first : first + block]).mean())
        minutes.append((robot.time - start) / 60.0)
    return {"errors [m]": means, "minutes": minutes, "examples": robot.learner.practised}


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every robot and what use teaches it."""
    rows, last = [], {}
    for case in _CASES:
        for learns, label in _LABELS.items():
            members = runs_with(runs, case=case, learns=learns)
            each = 1e3 * np.array([run.figures["errors [m]"] for run in members])
            last[case, learns] = float(each[:, -1].mean())
            rows.append(
                {
                    "robot": case,
                    "in use it": label,
                    "first goals [mm]": float(each[:, 0].mean()),
                    "last goals [mm]": last[case, learns],
                    "worst robot, last goals [mm]": float(each[:, -1].max()),
                    "robot minutes": float(
                        np.mean([run.figures["minutes"][-1] for run in members])
                    ),
                    "examples taken in use": float(
                        np.mean([run.figures["examples"] for run in members])
                    ),
                }
            )
    full = runs[0].settings["blocks"] == _BLOCKS
    bounds = [
        Bound.at_most(
            f"{case}: error on the last goals, {_LABELS[learns]} over {_LABELS['nothing']}",
            limit,
            last[case, learns] / last[case, "nothing"] if full else None,
        )
        for learns, limits in _LIMITS.items()
        for case, limit in zip(_CASES, limits, strict=True)
    ]
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw the error over the goals, an axis for the sound and one for the changed robot."""
    for axes, case in zip(figure.subplots(1, 2, sharey=True), _CASES, strict=True):
        for learns, colour in _COLOURS.items():
            members = runs_with(runs, case=case, learns=learns)
            each = 1e3 * np.array([run.figures["errors [m]"] for run in members])
            goals = members[0].settings["block"] * np.arange(1, each.shape[1] + 1)
            draw_spread(axes, goals.tolist(), each, colour, _LABELS[learns])
        axes.set(xlabel="goals since", title=case)
    figure.axes[0].set_ylabel("feed-forward error [mm]")
    figure.axes[0].legend(fontsize="small")


_NOTE = (
    "Every goal is sent once and was not practised before: its error is told before the movement "
    "at rest is learned. What goals in use teach is the learner's parameter `learn_in_use`. The "
    "article leaves open how a robot learns that is in use."
)

EXPERIMENT = Experiment(
    name="bha-use",
    claim="learning is online: it may go on for as long as the robot moves (section 2)",
    shows="errors of a robot in use, by what movements to a user's goals teach it",
    minutes=20.0,
    seeds=10,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `bha-use`."""
