"""What can be chosen about a demonstration, and how long its parts are."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

SPACES = ("2d", "3d")
ROBOTS = ("sim", "hardware-emulated")


@dataclass(frozen=True)
class DemoSettings:
    """A demonstration: identify, babble, reach.

    Attributes
    ----------
    space : What is learned, one of `SPACES`.
    minutes : Robot time of exploration [min].
    seed : Draws the robot, its noise, the exploration and the held-out goals.
    goals : Number of held-out goals.
    out : Folder for the report, the figures and the models.
    identification_samples : Settled postures for the pressure controller.
    robot : Which robot, one of `ROBOTS`.
    """

    space: str = "2d"
    minutes: float = 30.0
    seed: int = 0
    goals: int = 25
    out: Path = Path("results/demo")
    identification_samples: int = 40
    robot: str = "sim"

    def __post_init__(self) -> None:
        if self.space not in SPACES:
            raise ValueError(f"space is {self.space!r}; valid are {', '.join(SPACES)}")
        if self.robot not in ROBOTS:
            raise ValueError(f"robot must be one of {', '.join(ROBOTS)}, got {self.robot!r}")
        if not 0.0 < self.minutes <= 10_000.0:
            raise ValueError(f"minutes must be above 0 and at most 10000, got {self.minutes}")
        if not 1 <= self.goals <= 10_000:
            raise ValueError(f"goals must be 1 to 10000, got {self.goals}")
        if not 0 <= self.seed < 2**31:
            raise ValueError(f"seed must be 0 to {2**31 - 1}, got {self.seed}")
