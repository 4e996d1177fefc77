"""The figure of the table `bha-plant`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.engine.experiment import Run
from benchmarks.trunk.plant_properties import CURVE_STEP
from benchmarks.trunk.plant_table import Robot, reached

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BLUE, _ORANGE, _GREEN = "#0072b2", "#d55e00", "#009e73"


def draw_properties(runs: Sequence[Run], figure: Figure) -> None:
    """Draw settling, distances, ranges and reach of all robots."""
    robots: dict[int, Robot] = {}
    for run in runs:
        robots.setdefault(run.seed, {})[run.settings["measurement"]] = run.figures
    ((settling, distances), (ranges, reach)) = figure.subplots(2, 2)
    everyone = list(robots.values())
    _draw_settling(settling, everyone)
    _draw_distances(distances, everyone)
    seed, robot = next(iter(robots.items()))
    _draw_ranges(ranges, robot, seed)
    _draw_reach(reach, everyone)


def _draw_settling(axes: Axes, robots: Sequence[Robot]) -> None:
    for robot in robots:
        curve = 1e3 * np.array(robot["settling"]["curve [m]"])
        times = CURVE_STEP * np.arange(1, len(curve) + 1)
        axes.semilogy(times, np.maximum(curve, 0.1), color=_BLUE, linewidth=0.8, alpha=0.7)
    axes.axhline(5.0, color="0.4", linewidth=0.8)
    axes.axvspan(10.0, 20.0, color=_GREEN, alpha=0.15, label="must pass 5 mm here")
    axes.set(
        xlim=(0.0, 35.0),
        ylim=(1.0, None),
        xlabel="time after a step of the pressures [s]",
        ylabel="tip to its end [mm]",
        title="Settling, a line a robot (median of its steps)",
    )
    axes.legend(fontsize="small")


def _draw_distances(axes: Axes, robots: Sequence[Robot]) -> None:
    entries = {
        "repetition": ("repetition", "tip [m]", 4.0, 6.0),
        "... without play\nand drift": ("repetition, ideal cables", "tip [m]", None, None),
        "off constant\ncurvature": ("curvature", "mean [m]", 5.0, 15.0),
        "same pressures,\nother history": ("memory", "largest distance [m]", 20.0, 60.0),
    }
    for place, (measurement, name, low, high) in enumerate(entries.values()):
        values = [1e3 * robot[measurement][name] for robot in robots]
        if low is not None and high is not None:
            axes.fill_between(
                [place - 0.35, place + 0.35], low, high, color=_GREEN, alpha=0.15, linewidth=0
            )
        places = place + np.linspace(-0.2, 0.2, len(values))
        axes.plot(places, values, "o", color=_BLUE, markersize=4)
    axes.set_xticks(range(len(entries)), list(entries), fontsize="small")
    axes.set(
        ylim=(0.0, 60.0), ylabel="distance of the tip [mm]", title="A dot a robot; green: must"
    )


def _draw_ranges(axes: Axes, robot: Robot, seed: int) -> None:
    for shift, name, colour, label in (
        (-0.18, "ends [m]", _BLUE, "fresh"),
        (0.18, "ends an hour later [m]", _ORANGE, "after an hour of use"),
    ):
        low, high = 1e3 * np.array(robot["ranges"][name])
        axes.bar(
            np.arange(9) + shift, high - low, 0.32, bottom=low, color=colour, alpha=0.8, label=label
        )
    axes.set_xticks(range(9), [f"{s}.{c}" for s in (1, 2, 3) for c in (1, 2, 3)])
    axes.set(
        ylim=(100.0, 350.0),
        xlabel="bellows (segment.chamber)",
        ylabel="length [mm]",
        title=f"Usable ranges of robot {seed}, others at half pressure",
    )
    axes.legend(fontsize="small", loc="upper right", ncols=2)


def _draw_reach(axes: Axes, robots: Sequence[Robot]) -> None:
    goals = np.concatenate([reached(robot)[0] for robot in robots])
    within = np.concatenate([reached(robot)[1] for robot in robots])
    radii = np.linalg.norm(goals, axis=1)
    polar = np.degrees(np.arccos(goals[:, 2] / radii)).round(2)
    for radius, colour in zip((0.735, 0.78, 0.825), (_ORANGE, _BLUE, _GREEN), strict=True):
        shell = np.isclose(radii, radius)
        angles = np.unique(polar[shell])
        shares = [1e2 * within[shell & (polar == angle)].mean() for angle in angles]
        axes.plot(angles, shares, "o-", color=colour, markersize=4, label=f"r = {radius:g} m")
    axes.axhline(90.0, color="0.4", linewidth=0.8)
    axes.set(
        ylim=(0.0, 104.0),
        xlabel="polar angle of the goals [degrees]",
        ylabel="within 10 mm [%]",
        title="Task grid of the toolkit, all robots; all in all >= 90 %",
    )
    axes.legend(fontsize="small", loc="lower left")
