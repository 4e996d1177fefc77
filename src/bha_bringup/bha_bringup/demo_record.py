"""What a demonstration has measured, and its results file."""

from __future__ import annotations

import json
import math
import platform
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bha_bringup.demo_settings import DemoSettings
from bha_bringup.recording import Recording
from bha_common.files import atomic_write

Array = NDArray[np.float64]
SCHEMA = 1
_PACKAGES = ("numpy", "scipy", "mujoco", "numba", "rclpy", "ros-rclpy", "bha_bringup")


@dataclass
class GoalRecord:
    """How one held-out goal was reached.

    Attributes
    ----------
    goal, feedforward_tip, feedback_tip : Positions [m], shape (3,); None while not measured.
    feedforward_error, feedback_error : Distances in the task's coordinates [m].
    feedback_time : Robot time with feedback [s].
    """

    goal: Array
    feedforward_tip: Array | None = None
    feedforward_error: float = math.nan
    feedback_tip: Array | None = None
    feedback_error: float = math.nan
    feedback_time: float = math.nan


@dataclass
class DemoRecord:
    """Everything that a demonstration has measured so far.

    Attributes
    ----------
    settings : What was asked for.
    axes : Coordinates of the tip that the errors count.
    learning_curve : Exploration time [min] and recent error [m] over the babbling.
    wall : Wall time of each phase [s].
    """

    settings: DemoSettings
    axes: tuple[str, ...] = ("x", "y", "z")
    exploration_minutes: float = 0.0
    movements: int = 0
    samples: int = 0
    local_models: int = 0
    pressure_error: float = math.nan
    home_error: float = math.nan
    real_time_factor: float = math.nan
    goals: list[GoalRecord] = field(default_factory=list)
    learning_curve: list[tuple[float, float]] = field(default_factory=list)
    wall: dict[str, float] = field(default_factory=dict)
    reach: Recording = field(default_factory=Recording)
    reach_goal: Array | None = None
    complete: bool = False

    def errors(self, kind: str) -> Array:
        """Errors of the goals measured so far [m]; kind is ``feedforward`` or ``feedback``."""
        values = np.array([getattr(goal, f"{kind}_error") for goal in self.goals], dtype=float)
        return np.asarray(values[np.isfinite(values)])

    def as_json(self) -> dict[str, Any]:
        """Return the contents of ``results.json``; what was not measured is null."""
        return {
            "schema": SCHEMA,
            "robot": self.settings.robot,
            "space": self.settings.space,
            "axes": list(self.axes),
            "seed": self.settings.seed,
            "complete": self.complete,
            "exploration_minutes": self.exploration_minutes,
            "movements": self.movements,
            "samples": self.samples,
            "local_models": self.local_models,
            "pressure_error_pa": _number(self.pressure_error),
            "goals": [
                {
                    "goal": _point(goal.goal),
                    "feedforward_tip": _point(goal.feedforward_tip),
                    "feedforward_error_m": _number(goal.feedforward_error),
                    "feedback_tip": _point(goal.feedback_tip),
                    "feedback_error_m": _number(goal.feedback_error),
                    "feedback_time_s": _number(goal.feedback_time),
                }
                for goal in self.goals
            ],
            "feedforward": statistics(self.errors("feedforward")),
            "feedback": statistics(self.errors("feedback")),
            "home_error_m": _number(self.home_error),
            "real_time_factor": _number(self.real_time_factor),
            "wall_s": {name: round(seconds, 3) for name, seconds in self.wall.items()},
            "versions": versions(),
        }

    def write(self, folder: Path) -> Path:
        """Write ``results.json`` into a folder; its path."""
        path = folder / "results.json"
        atomic_write(path, (json.dumps(self.as_json(), indent=1) + "\n").encode())
        return path


def statistics(errors: Array) -> dict[str, float | None]:
    """Mean, median and 95th percentile of errors [m]; null without any."""
    if not len(errors):
        return {"mean_m": None, "median_m": None, "p95_m": None}
    return {
        "mean_m": float(np.mean(errors)),
        "median_m": float(np.median(errors)),
        "p95_m": float(np.percentile(errors, 95)),
    }


def versions() -> dict[str, str]:
    """Tell the versions of Python and of the packages that the results depend on."""
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _point(value: Array | None) -> list[float] | None:
    return None if value is None else [float(coordinate) for coordinate in value]
