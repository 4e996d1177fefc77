"""Learning on the trunk from nothing: the error on held-out goals over exploration time.

The tables `bha-2d` and `bha-3d` are made of this.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.engine.experiment import Figures, Run, Settings, runs_with
from benchmarks.trunk.bha_runs import (
    COLOURS,
    METHODS,
    Array,
    draw_spread,
    held_out,
    offsets,
    task_of,
)
from bha_bringup.in_process import InProcessRobot

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MINUTES = [5.0, 15.0, 30.0, 60.0, 90.0]
GOALS = 25
_QUICK_MINUTES = [1.0, 2.0]
_QUICK_GOALS = 3


def plan(space: str, quick: bool) -> Sequence[Settings]:
    """Return both methods in one space."""
    return [
        {
            "space": space,
            "method": method,
            "minutes": _QUICK_MINUTES if quick else MINUTES,
            "goals": _QUICK_GOALS if quick else GOALS,
        }
        for method in METHODS
    ]


def run(seed: int, *, space: str, method: str, minutes: list[float], goals: int) -> Figures:
    """Let one robot identify its pressures and babble, and send it to held-out goals in between.

    Exploration counts from the first movement to home on; what the goals take counts as age of
    the robot, and teaches nothing but what its potentiometers are off by just then.
    """
    task = task_of(space, method)
    robot = InProcessRobot(task, seed=seed)
    robot.identify(20 if goals == _QUICK_GOALS else None)
    targets = held_out(task, seed, goals)
    explored, found = 0.0, []
    for minute in minutes:
        robot.babble((minute - explored) * 60.0)
        explored = minute
        found.append(offsets(robot, targets))
    babbler = robot.learner.babbler
    assert babbler is not None
    return {
        "minutes": minutes,
        "goals [m]": targets,
        "offsets [m]": np.array(found),
        "movements": babbler.movements,
        "samples": babbler.samples,
        "maps": babbler.local_maps,
    }


def distances(runs: Sequence[Run]) -> Array:
    """Return the error [mm] of robots, after times, at goals: shape (R, T, G)."""
    each = np.array([run.figures["offsets [m]"] for run in runs])
    return np.asarray(1e3 * np.linalg.norm(each, axis=3))


def along_directions(runs: Sequence[Run]) -> Array:
    """Return mean errors [mm] along the axes and away from the base, shape (T, n + 1).

    The last column is the share of the error in the direction of the goal as seen from the base,
    that in which the trunk can only stretch. It needs three coordinates.
    """
    each = 1e3 * np.array([run.figures["offsets [m]"] for run in runs])
    columns = [np.abs(each).mean(axis=(0, 2))]
    goals = np.array([run.figures["goals [m]"] for run in runs])
    away = goals / np.linalg.norm(goals, axis=2, keepdims=True)
    radial = np.einsum("rtgn,rgn->rtg", each, away[..., : each.shape[3]])
    columns.append(np.abs(radial).mean(axis=(0, 2))[:, np.newaxis])
    return np.hstack(columns)


def rows_of(runs: Sequence[Run]) -> list[dict[str, Any]]:
    """Return a row for every method and time."""
    rows: list[dict[str, Any]] = []
    for method in METHODS:
        members = runs_with(runs, method=method)
        if not members:
            continue
        each, along = distances(members), along_directions(members)
        for index, minute in enumerate(members[0].figures["minutes"]):
            robots = each[:, index].mean(axis=1)
            row: dict[str, Any] = {
                "method": method,
                "exploration [min]": minute,
                "error, mean [mm]": float(robots.mean()),
                "best robot [mm]": float(robots.min()),
                "worst robot [mm]": float(robots.max()),
                "median goal [mm]": float(np.median(each[:, index])),
                "worst goal [mm]": float(each[:, index].max()),
            }
            names = ("x", "y", "z")[: along.shape[1] - 1]
            for name, value in zip(names, along[index], strict=False):
                row[f"along {name} [mm]"] = float(value)
            if len(names) == 3:
                row["away from the base [mm]"] = float(along[index, -1])
            rows.append(row)
    return rows


def robots_after(runs: Sequence[Run], method: str, minute: float) -> Array | None:
    """Return the mean error of every robot [mm] after a time; None if it was not measured."""
    members = runs_with(runs, method=method)
    if not members or minute not in members[0].figures["minutes"]:
        return None
    index = members[0].figures["minutes"].index(minute)
    return np.asarray(distances(members)[:, index].mean(axis=1))


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw the error over exploration time, and where it points to."""
    left, right = figure.subplots(1, 2)
    for method, colour in COLOURS.items():
        members = runs_with(runs, method=method)
        if not members:
            continue
        minutes = members[0].figures["minutes"]
        draw_spread(left, minutes, distances(members).mean(axis=2), colour, method)
        ordered = np.sort(distances(members)[:, -1].ravel())
        right.plot(ordered, np.linspace(0.0, 100.0, len(ordered)), color=colour, label=method)
    left.axhline(10.0, color="0.6", linewidth=0.8)
    left.set(
        xlabel="exploration [robot minutes]",
        ylabel="feed-forward error, mean over held-out goals [mm]",
        yscale="log",
        title="Mean of the robots, and their range",
    )
    right.axvline(10.0, color="0.6", linewidth=0.8)
    right.set(
        xlabel="error [mm]",
        ylabel="goals within [%]",
        xscale="log",
        title="All goals of all robots at the end",
    )
    left.legend(fontsize="small")
