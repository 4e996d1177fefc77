"""The figures of a demonstration: learning curve, goals and tips, lengths and pressures."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")  # no display is needed, and none may be there

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure

from bha_bringup.demo_record import DemoRecord
from bha_common import bellows

_FEEDFORWARD, _FEEDBACK, _GOAL = "#0072b2", "#d55e00", "#444444"  # safe for the colour-blind
_SEGMENTS = ("#0072b2", "#009e73", "#d55e00")
_MILLI, _KILO = 1e3, 1e-3


def write_figures(record: DemoRecord, folder: Path) -> list[Path]:
    """Draw every figure that there is data for, as PNG; their paths."""
    figures: dict[str, Figure] = {}
    if record.learning_curve:
        figures["learning_curve"] = learning_curve(record)
    if any(goal.feedforward_tip is not None for goal in record.goals):
        figures["goals"] = goals_and_tips(record)
    if record.reach.lengths:
        figures["reach"] = one_reach(record)
    paths = []
    for name, figure in figures.items():
        path = folder / f"{name}.png"
        figure.savefig(path, dpi=120)
        plt.close(figure)
        paths.append(path)
    return paths


def learning_curve(record: DemoRecord) -> Figure:
    """Recent error over exploration time, with the errors measured afterwards as lines."""
    figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
    minutes, errors = np.array(record.learning_curve).T
    axes.plot(minutes, errors * _MILLI, color=_GOAL, label="while babbling, with its noise")
    for kind, colour, label in (
        ("feedforward", _FEEDFORWARD, "held-out goals, feed-forward"),
        ("feedback", _FEEDBACK, "held-out goals, with feedback"),
    ):
        measured = record.errors(kind)
        if len(measured):
            mean = float(np.mean(measured)) * _MILLI
            axes.axhline(mean, color=colour, linestyle="--", label=f"{label}: {mean:.1f} mm")
    axes.set(
        xlabel="exploration [robot minutes]",
        ylabel="mean distance to the goal [mm]",
        yscale="log",
        title=f"Goal babbling, task {record.settings.space}, robot {record.settings.seed}",
    )
    axes.grid(True, which="both", alpha=0.25)
    axes.legend(frameon=False)
    return figure


def goals_and_tips(record: DemoRecord) -> Figure:
    """Held-out goals and where the tip came to, from above and from the side."""
    figure, panels = plt.subplots(1, 2, figsize=(10, 5), layout="constrained")
    for axes, (first, second) in zip(panels, ((0, 1), (0, 2)), strict=True):
        for goal in record.goals:
            for tip, colour in (
                (goal.feedforward_tip, _FEEDFORWARD),
                (goal.feedback_tip, _FEEDBACK),
            ):
                if tip is not None:
                    pair = np.array([goal.goal, tip])
                    axes.plot(pair[:, first], pair[:, second], color=colour, linewidth=0.8)
                    axes.plot(*tip[[first, second]], "o", color=colour, markersize=4)
            axes.plot(*goal.goal[[first, second]], "+", color=_GOAL, markersize=8)
        axes.set_aspect("equal")
        axes.grid(True, alpha=0.25)
        axes.set(xlabel=f"{'xyz'[first]} [m]", ylabel=f"{'xyz'[second]} [m]")
    panels[0].set_title("seen along the trunk")
    panels[1].set_title(
        "seen from the side" + ("" if "z" in record.axes else " (z is left open by this task)")
    )
    panels[1].invert_yaxis()  # the trunk hangs: z points down
    for colour, marker, label in (
        (_GOAL, "+", "goal"),
        (_FEEDFORWARD, "o", "tip, feed-forward"),
        (_FEEDBACK, "o", "tip, with feedback"),
    ):
        panels[0].plot([], [], marker, color=colour, label=label)
    panels[0].legend(frameon=False, loc="upper left", fontsize="small")
    return figure


def one_reach(record: DemoRecord) -> Figure:
    """Lengths, pressures and the distance to the goal over one feed-forward movement."""
    figure, panels = plt.subplots(3, 1, figsize=(8, 8), sharex=True, layout="constrained")
    recording = record.reach
    start = recording.lengths[0][0]
    for axes, series, factor, label in (
        (panels[0], recording.lengths, _MILLI, "bellows length [mm]"),
        (panels[1], recording.pressures, _KILO, "bellows pressure [kPa]"),
    ):
        for index in range(bellows.COUNT):
            times = [time - start for time, _ in series]
            axes.plot(
                times,
                [values[index] * factor for _, values in series],
                color=_SEGMENTS[index // bellows.CHAMBERS],
                linewidth=0.8,
            )
        axes.set_ylabel(label)
        axes.grid(True, alpha=0.25)
    for segment, colour in enumerate(_SEGMENTS, start=1):
        panels[0].plot([], [], color=colour, label=f"segment {segment}")
    panels[0].legend(frameon=False, ncols=3, fontsize="small")
    if record.reach_goal is not None and recording.tips:
        count = len(record.axes)
        distance = [
            np.linalg.norm((tip - record.reach_goal)[:count]) * _MILLI for _, tip in recording.tips
        ]
        panels[2].plot([time - start for time, _ in recording.tips], distance, color=_FEEDFORWARD)
        panels[2].set(ylabel="distance to the goal [mm]", yscale="log")
        panels[2].grid(True, which="both", alpha=0.25)
    panels[2].set_xlabel("robot time [s]")
    panels[0].set_title("One feed-forward movement")
    return figure
