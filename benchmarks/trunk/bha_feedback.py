"""Cartesian feedback on the trunk: how exact, how fast, and stable at every setting there is.

The tracker sees the tip with noise; errors are those of the true tip.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
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
from benchmarks.trunk.bha_runs import Array, errors, held_out, task_of
from benchmarks.trunk.plant_properties import repetition
from bha_bringup.in_process import InProcessRobot
from bha_cartesian_feedback.goal_integrator import FeedbackSettings
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TRACKER_NOISE = 1.5e-3  # [m] standard deviation of a coordinate
_MINUTES = 60.0
_GOALS, _CORNER_GOALS = 25, 2
_LAST = 10.0  # [s] at the end of a movement in which a stable one hardly moves
_SWING = 0.005  # [m] that it may then be off its mean, root mean square; held still it is 1 to 2 mm
_SLACK = 0.005  # [m] by which feedback may end farther away than feed-forward did

CORNERS: list[dict[str, float]] = [
    {"gain": gain, "max_speed": speed, "max_correction": 0.5, "feedforward_time": wait}
    for gain, speed, wait in product((0.05, 0.5), (0.005, 10.0), (1.0, 3.0))
]
"""Settings of the feedback at the ends of what they may be, as far as they make it faster."""


def plan(quick: bool) -> Sequence[Settings]:
    """Return exactness in both spaces, and the corners of the settings."""
    minutes, goals = (1.0, 2) if quick else (_MINUTES, _GOALS)
    exact = [
        {"part": "exactness", "space": space, "minutes": minutes, "goals": goals}
        for space in ("2d", "3d")
    ]
    corners = {"part": "corners", "space": "3d", "minutes": minutes}
    return [*exact, {**corners, "goals": _CORNER_GOALS}]


def run(seed: int, *, part: str, space: str, minutes: float, goals: int) -> Figures:
    """Let a robot learn, then send it to goals with and without feedback."""
    task = task_of(space)
    robot = InProcessRobot(task, seed=seed, tip_noise=TRACKER_NOISE)
    robot.identify(20 if minutes < 5.0 else None)
    robot.babble(60.0 * minutes)
    targets = held_out(task, seed, goals)
    if part == "corners":
        return {"movements": _corners(robot, targets)}
    plain = errors(robot, targets)
    corrected, durations, arrived = [], [], []
    for goal in targets:
        integrator = robot.reach_with_feedback(goal)
        corrected.append(_distances(robot, goal, [robot.plant.state.tip])[0])
        durations.append(integrator.elapsed)
        arrived.append(integrator.arrived)
    plant = Plant(draw_robot(load_parameters(), seed), seed=seed)
    repeated = repetition(plant, np.random.default_rng(seed), 1.0 if minutes >= 5.0 else 0.02)
    return {
        "feed-forward [m]": plain,
        "feedback [m]": corrected,
        "durations [s]": durations,
        "arrived": arrived,
        "repetition [m]": repeated["tip [m]"],
    }


def _corners(robot: InProcessRobot, goals: Array) -> list[dict[str, Any]]:
    """Go from goal to goal with every corner of the settings, a minute each; see how it ends."""
    found = []
    plain = errors(robot, goals)
    for corner in CORNERS:
        settings = FeedbackSettings(**corner, rest_time=60.0, timeout=60.0)
        for goal, without in zip(goals, plain, strict=True):
            tips: list[Array] = []

            def note(tips: list[Array] = tips) -> None:
                tips.append(robot.plant.state.tip)

            robot.reach_with_feedback(goal, settings, watch=note)
            count = round(_LAST * len(tips) / settings.timeout)
            last = robot.learner.task.outcome(np.array(tips[-count:]))
            found.append(
                {
                    **corner,
                    "feed-forward [m]": without,
                    "at the end [m]": float(_distances(robot, goal, tips[-count:]).mean()),
                    "swing [m]": float(np.linalg.norm(np.std(last, axis=0))),
                }
            )
    return found


def _distances(robot: InProcessRobot, goal: Array, tips: Sequence[Array]) -> Array:
    """Return distances of tips (N, 3) from a goal (3,) in what counts [m], shape (N,)."""
    task = robot.learner.task
    return np.asarray(np.linalg.norm(task.outcome(np.array(tips)) - task.outcome(goal), axis=1))


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every space, and one for every corner of the settings."""
    rows: list[dict[str, Any]] = []
    bounds = []
    for space in ("2d", "3d"):
        members = runs_with(runs, part="exactness", space=space)
        full = bool(members) and members[0].settings["minutes"] >= _MINUTES
        if not members:
            continue
        plain, corrected = (
            1e3 * np.array([run.figures[name] for run in members])
            for name in ("feed-forward [m]", "feedback [m]")
        )
        repeated = 1e3 * np.array([run.figures["repetition [m]"] for run in members])
        shares = corrected.mean(axis=1) / repeated
        durations, arrived = (
            np.array([run.figures[name] for run in members])
            for name in ("durations [s]", "arrived")
        )
        rows.append(
            {
                "what": f"{space}, default settings",
                "feed-forward [mm]": float(plain.mean()),
                "feedback, mean [mm]": float(corrected.mean()),
                "worst robot [mm]": float(corrected.mean(axis=1).max()),
                "worst goal [mm]": float(corrected.max()),
                "repetition [mm]": float(repeated.mean()),
                "time, mean [s]": float(durations.mean()),
                "longest [s]": float(durations.max()),
                "arrived [%]": 1e2 * float(arrived.mean()),
                "swing at the end, rms, largest [mm]": None,
            }
        )
        measured = (float(corrected.mean()), float(shares.mean()), float(durations.max()))
        bounds += _bounds(space, measured if full else None)
    movements = [
        each for run in runs_with(runs, part="corners") for each in run.figures["movements"]
    ]
    for corner in CORNERS:
        chosen = [each for each in movements if corner.items() <= each.items()]
        if not chosen:
            continue
        ends = 1e3 * np.array([each["at the end [m]"] for each in chosen])
        rows.append(
            {
                "what": ", ".join(f"{name} {value:g}" for name, value in corner.items()),
                "feed-forward [mm]": 1e3
                * float(np.mean([each["feed-forward [m]"] for each in chosen])),
                "feedback, mean [mm]": float(ends.mean()),
                "worst robot [mm]": None,
                "worst goal [mm]": float(ends.max()),
                "repetition [mm]": None,
                "time, mean [s]": 60.0,
                "longest [s]": 60.0,
                "arrived [%]": None,
                "swing at the end, rms, largest [mm]": 1e3
                * max(float(each["swing [m]"]) for each in chosen),
            }
        )
    if movements:
        unstable = sum(not _stable(each) for each in movements)
        bounds.append(Bound.at_most("movements that swing or end farther away", 0, unstable))
    return Summary(rows, bounds, _NOTE)


def _bounds(space: str, measured: tuple[float, float, float] | None) -> list[Bound]:
    mean, share, longest = measured or (None, None, None)
    return [
        Bound.at_most(f"{space}: error with feedback, mean [mm]", 4.0, mean),
        Bound.at_most(f"{space}: the same over the repetition accuracy [-]", 0.9, share),
        Bound.at_most(f"{space}: longest movement [s]", 30.2, longest),
    ]


def _stable(movement: dict[str, Any]) -> bool:
    away = movement["at the end [m]"] - movement["feed-forward [m]"]
    return bool(movement["swing [m]"] <= _SWING and away <= _SLACK)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw errors of all goals with and without feedback, and the corners."""
    left, right = figure.subplots(1, 2)
    for space, style in (("2d", "-"), ("3d", "--")):
        members = runs_with(runs, part="exactness", space=space)
        for name, colour in (("feed-forward [m]", "#d55e00"), ("feedback [m]", "#0072b2")):
            if not members:
                continue
            values = np.sort(1e3 * np.concatenate([run.figures[name] for run in members]))
            share = np.linspace(0.0, 100.0, len(values))
            left.plot(values, share, style, color=colour, label=f"{space} {name[:-4]}")
    left.set(xlabel="error [mm]", ylabel="goals within [%]", xscale="log", title="Held-out goals")
    left.legend(fontsize="small")
    movements = [
        each for run in runs_with(runs, part="corners") for each in run.figures["movements"]
    ]
    gains = np.array([each["gain"] for each in movements])
    jitter = np.random.default_rng(0).uniform(0.95, 1.05, len(gains))
    right.semilogx(gains * jitter, [1e3 * each["swing [m]"] for each in movements], ".")
    right.axhline(1e3 * _SWING, color="0.6", linewidth=0.8)
    right.set(
        xlabel="gain of the settings [1/s]",
        ylabel=f"tip off its mean in the last {_LAST:g} s, rms [mm]",
        title="At the corners of the settings",
    )


_NOTE = (
    f"The tracker sees the tip with {1e3 * TRACKER_NOISE:g} mm of noise a coordinate; errors are "
    "those of the true tip when the movement ends. It begins at the goal before, and ends when the "
    "tip has stayed within 2 mm for 3 s as far as the tracker can tell (`arrived`), at the latest "
    "after 30 s; the feed-forward part of the way is in the times. A movement counts as "
    f"unstable when the tip is more than {1e3 * _SWING:g} mm off its mean (root mean square) in "
    f"the last {_LAST:g} s of a minute, or ends {1e3 * _SLACK:g} mm farther away than feed-forward "
    "control had it."
)

EXPERIMENT = Experiment(
    name="bha-feedback",
    claim="6 to 8 mm with Cartesian feedback, slowly; repetition accuracy 5 mm (section 4)",
    shows="errors with and without feedback beside the measured repetition accuracy, their time, "
    "and feedback at the ends of its settings",
    minutes=30.0,
    seeds=10,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `bha-feedback`."""
