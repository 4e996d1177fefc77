"""The properties of a robot that the table `bha-plant` shows, and what each must be."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.engine.experiment import Figures

Array = NDArray[np.float64]

Robot = dict[str, Figures]
"""What was measured on one robot, by the names of the measurements."""


@dataclass(frozen=True)
class Property:
    """A row of the table.

    Attributes
    ----------
    name : What it is, with its unit.
    value : Gives it for one robot.
    low, high : What its mean over the robots must lie between.
    """

    name: str
    value: Callable[[Robot], float]
    low: float = -math.inf
    high: float = math.inf

    @property
    def bounded(self) -> bool:
        """Whether it must be anything."""
        return math.isfinite(self.low) or math.isfinite(self.high)

    @property
    def demand(self) -> str:
        """The bound in words."""
        if not self.bounded:
            return ""
        if math.isinf(self.high):
            return f">= {self.low:g}"
        return f"<= {self.high:g}" if math.isinf(self.low) else f"{self.low:g} to {self.high:g}"

    def within(self, values: Array) -> NDArray[np.bool_]:
        """Tell of each robot whether it is within the bound."""
        return (values >= self.low) & (values <= self.high)


def reached(robot: Robot) -> tuple[Array, NDArray[np.bool_]]:
    """Goals of the task grid [m], shape (n, 3), and which of them are reached within 10 mm."""
    shells = [figures for name, figures in robot.items() if name.startswith("reach ")]
    errors = np.concatenate([shell["errors [m]"] for shell in shells])
    return np.concatenate([shell["goals [m]"] for shell in shells]), errors < 0.010


def range_widths(robot: Robot) -> Array:
    """Usable range of each bellows [m], shape (9,)."""
    low, high = np.array(robot["ranges"]["ends [m]"])
    return high - low


def moved_ends(robot: Robot) -> Array:
    """How far each end moved in an hour over the range of its bellows [-], shape (2, 9)."""
    moved = np.array(robot["ranges"]["ends an hour later [m]"]) - robot["ranges"]["ends [m]"]
    return np.abs(moved) / range_widths(robot)


def _of(measurement: str, figure: str, scale: float = 1.0) -> Callable[[Robot], float]:
    def value(robot: Robot) -> float:
        figures: dict[str, Any] = robot[measurement]
        return scale * float(figures[figure])

    return value


_MM, _PERCENT = 1e3, 1e2
_DRAWN = ("stiffnesses", "areas", "friction", "creep", "masses")

PROPERTIES = (
    Property("settling of the tip to 5 mm, median step [s]", _of("settling", "median [s]"), 10, 20),
    Property("the same, 90th percentile [s]", _of("settling", "p90 [s]")),
    Property("repetition accuracy of the tip [mm]", _of("repetition", "tip [m]", _MM), 4, 6),
    Property(
        "standard deviation of the measured lengths meanwhile [mm]",
        _of("repetition", "measured lengths [m]", _MM),
    ),
    Property(
        "standard deviation of the true lengths meanwhile [mm]",
        _of("repetition", "true lengths [m]", _MM),
    ),
    Property(
        "repetition accuracy if cables had no play and drift [mm]",
        _of("repetition, ideal cables", "tip [m]", _MM),
    ),
    Property(
        "spread of the tip at the same pressures, 8 histories [mm]",
        _of("memory", "largest distance [m]", _MM),
        20,
    ),
    Property(
        "usable range of a bellows, narrowest [mm]",
        lambda robot: float(_MM * range_widths(robot).min()),
    ),
    Property(
        "usable range of a bellows, widest [mm] (0.1 to 0.3 m in the toolkit)",
        lambda robot: float(_MM * range_widths(robot).max()),
        high=200,
    ),
    Property(
        "widest over narrowest range of a robot [-]",
        lambda robot: float(np.ptp(range_widths(robot)) / range_widths(robot).min() + 1.0),
        1.1,
    ),
    Property(
        "lower ends move in an hour [% of the range]",
        lambda robot: float(_PERCENT * moved_ends(robot)[0].mean()),
        5,
    ),
    Property(
        "upper ends move in an hour [% of the range]",
        lambda robot: float(_PERCENT * moved_ends(robot)[1].mean()),
        5,
    ),
    Property(
        "distance of the tip from constant curvature [mm]",
        _of("curvature", "mean [m]", _MM),
        5,
        15,
    ),
    Property(
        "task grid of the toolkit within 10 mm [%]",
        lambda robot: float(_PERCENT * reached(robot)[1].mean()),
        90,
    ),
    Property("largest twist, bellows empty or full [degrees]", _of("twist", "largest [rad]", 57.3)),
    Property("dead time [s]", _of("pneumatics", "dead time [s]"), 0.02),
    Property("lag of filling [s]", _of("pneumatics", "lag of filling [s]"), 0.05),
    Property("lag of venting [s]", _of("pneumatics", "lag of venting [s]"), 0.05),
    Property("play of the regulators [Pa]", _of("pneumatics", "play of the regulators [Pa]"), 100),
    Property("potentiometers: noise [mm]", _of("potentiometers", "noise [m]", _MM), 0.1),
    Property("potentiometers: step [mm]", _of("potentiometers", "step [m]", _MM), 0.1),
    Property("potentiometers: play [mm]", _of("potentiometers", "play [m]", _MM), 0.1),
    Property(
        "potentiometers: drift in an hour [mm]",
        _of("potentiometers", "drift in an hour [m]", _MM),
        0.1,
    ),
    *(
        Property(
            f"{name} of the robot off its kind, largest [%]", _of("draw", name, _PERCENT), 3, 15
        )
        for name in _DRAWN
    ),
    Property(
        "sensor offset of the robot, largest [mm]", _of("draw", "sensor offsets [m]", _MM), 1, 5
    ),
    Property("times real time of processor time [-]", _of("speed", "times real time, median"), 150),
)
