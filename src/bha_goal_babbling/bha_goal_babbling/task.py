"""What is to be learned: which coordinates of the tip count, where the goals lie, how to explore.

A task stands in a YAML file; config/task_2d.yaml and config/task_3d.yaml are examples that name
every entry.
"""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike

from bha_common import bellows
from bha_common.share import share_file
from bha_goal_babbling.arrays import FloatArray, vector
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.errors import GoalBabblingError, InvalidTaskError
from bha_goal_babbling.goal_region import GoalRegion

AXES = (("x", "y"), ("x", "y", "z"))
"""The choices of coordinates that a task can have, in frame `bha_base`."""
_AXES_CHOICES = " or ".join(f"[{', '.join(axes)}]" for axes in AXES)

_ENTRIES = ("name", "axes", "goals", "home_lengths", "length_limits", "babbler")
_GOAL_ENTRIES = ("radii", "polar_max_degrees", "polar_steps", "azimuth_steps")
_GRID_CLEARANCE = 1e-3


@dataclass(frozen=True)
class Task:
    """A task for goal babbling on the trunk: actions are bellows lengths, outcomes are the tip's.

    Attributes
    ----------
    name : str
        Name of the task.
    axes : tuple of str
        Coordinates of the tip that count, one of `AXES`; their number is n.
    region : GoalRegion
        Where the goals lie.
    home_action : array
        Bellows lengths at home [m], shape (9,).
    action_low, action_high : array
        Limits of the bellows lengths [m], shape (9,).
    config : GoalBabblerConfig
        Settings of the learner.
    """

    name: str
    axes: tuple[str, ...]
    region: GoalRegion
    home_action: FloatArray
    action_low: FloatArray
    action_high: FloatArray
    config: GoalBabblerConfig

    def __post_init__(self) -> None:
        """Check the entries and make the arrays read-only.

        Raises
        ------
        InvalidTaskError
            Naming the entry, its value and what would be right.
        """
        if self.axes not in AXES:
            raise InvalidTaskError(f"axes must be {_AXES_CHOICES}, got {self.axes!r}")
        for name in ("home_action", "action_low", "action_high"):
            array = vector(name, getattr(self, name), bellows.COUNT)
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        if not ((self.action_low < self.home_action) & (self.home_action < self.action_high)).all():
            raise InvalidTaskError(
                f"home_lengths must lie inside length_limits, got {self.home_action.tolist()} "
                f"for {self.action_low.tolist()} to {self.action_high.tolist()}"
            )
        lowest, highest = float(self.action_low.min()), float(self.action_high.max())
        if lowest < bellows.MIN_LENGTH or highest > bellows.MAX_LENGTH:
            raise InvalidTaskError(
                f"length_limits must lie within {bellows.MIN_LENGTH:g} to {bellows.MAX_LENGTH:g} "
                f"m, the lengths that can be commanded, got {lowest:g} to {highest:g}"
            )
        farthest = self.region.radii[-1]
        if farthest > bellows.MAX_REACH:
            raise InvalidTaskError(
                f"goals.radii must be at most {bellows.MAX_REACH:g} m, got {farthest:g}"
            )

    @property
    def outcome_size(self) -> int:
        """Number n of coordinates that count."""
        return len(self.axes)

    def outcome(self, tip: ArrayLike) -> FloatArray:
        """Return the coordinates that count, shape (n,) or (N, n), of tips (3,) or (N, 3) [m]."""
        return np.array(np.asarray(tip, dtype=np.float64)[..., : self.outcome_size])

    def goals(self) -> FloatArray:
        """Return the goal set for babbling [m], shape (G, n)."""
        return self.outcome(self.region.grid())

    def held_out_positions(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return positions for tests [m], shape (count, 3), that are no goals of the babbling.

        They are drawn uniformly within the region, at least 1 mm from every goal of the grid.
        Their first n coordinates are the goals; the rest is for drawings.

        Parameters
        ----------
        count : int
            How many.
        rng : numpy.random.Generator
            Source of randomness.
        """
        grid = self.goals()
        chosen = np.empty((0, 3))
        while len(chosen) < count:
            drawn = self.region.draw(count, rng)
            gaps = np.linalg.norm(self.outcome(drawn)[:, np.newaxis] - grid, axis=2).min(axis=1)
            chosen = np.concatenate([chosen, drawn[gaps > _GRID_CLEARANCE]])
        return chosen[:count]

    def held_out_goals(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return goals for tests [m], shape (count, n): what counts of `held_out_positions`."""
        return self.outcome(self.held_out_positions(count, rng))

    def why_refused(self, goal: ArrayLike, margin: float = 0.02) -> str | None:
        """Return why a goal cannot be accepted, or None if it can.

        Parameters
        ----------
        goal : array_like
            Goal [m], shape (n,).
        margin : float
            How far outside of the region a goal may be [m].
        """
        try:
            point = vector("goal", goal, self.outcome_size)
        except GoalBabblingError as error:
            return str(error)
        if self.outcome_size == 3:
            return self.region.why_outside(point, margin)
        return self.region.why_too_far_aside(point, margin)

    @classmethod
    def from_mapping(cls, entries: Mapping[str, Any]) -> "Task":
        """Return the task with the entries of a task file.

        Raises
        ------
        InvalidTaskError
            Naming the entry, and what would be right.
        """
        _check_entries("the task", entries, _ENTRIES)
        _check_entries("goals", entries["goals"], _GOAL_ENTRIES)
        goals, limits = entries["goals"], entries["length_limits"]
        if not isinstance(limits, list | tuple) or len(limits) != 2:
            raise InvalidTaskError(f"length_limits must be [lowest, highest] [m], got {limits!r}")
        if not isinstance(entries["babbler"], Mapping):
            raise InvalidTaskError(f"babbler must hold settings, got {entries['babbler']!r}")
        try:
            region = GoalRegion(
                tuple(vector("goals.radii", goals["radii"]).tolist()),
                math.radians(_number("goals.polar_max_degrees", goals["polar_max_degrees"])),
                _whole("goals.polar_steps", goals["polar_steps"]),
                _whole("goals.azimuth_steps", goals["azimuth_steps"]),
            )
            return cls(
                str(entries["name"]),
                _axes(entries["axes"]),
                region,
                _lengths("home_lengths", entries["home_lengths"]),
                _lengths("length_limits", limits[0]),
                _lengths("length_limits", limits[1]),
                GoalBabblerConfig.from_mapping(entries["babbler"]),
            )
        except InvalidTaskError:
            raise
        except (GoalBabblingError, TypeError) as error:
            raise InvalidTaskError(str(error)) from error


def find_task(task: str) -> Task:
    """Return a task of this package by its name, such as ``2d``, or the one in a file.

    Raises
    ------
    InvalidTaskError
        When there is neither, or the file cannot be used.
    """
    try:
        return load_task(share_file(__file__, "config", f"task_{task}.yaml"))
    except FileNotFoundError:
        return load_task(Path(task).expanduser())


def load_task(path: str | os.PathLike[str]) -> Task:
    """Return the task from a YAML file.

    Raises
    ------
    InvalidTaskError
        Naming the file, the entry, and what would be right.
    """
    try:
        entries = yaml.safe_load(Path(path).read_text(encoding="utf-8"))
        return Task.from_mapping(entries)
    except OSError as error:
        raise InvalidTaskError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InvalidTaskError(f"{path}: is not text in UTF-8") from error
    except yaml.YAMLError as error:
        raise InvalidTaskError(f"{path}: is not valid YAML: {error}") from error
    except InvalidTaskError as error:
        raise InvalidTaskError(f"{path}: {error}") from error


def _check_entries(owner: str, entries: Any, names: tuple[str, ...]) -> None:
    if not isinstance(entries, Mapping):
        raise InvalidTaskError(f"{owner} must hold the entries {', '.join(names)}, got {entries!r}")
    missing = [name for name in names if name not in entries]
    unknown = [str(name) for name in entries if name not in names]
    if missing or unknown:
        complaints = [f"misses {', '.join(missing)}"] if missing else []
        complaints += [f"has unknown {', '.join(unknown)}"] if unknown else []
        raise InvalidTaskError(
            f"{owner} {' and '.join(complaints)}; its entries are {', '.join(names)}"
        )


def _axes(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list | tuple):
        raise InvalidTaskError(f"axes must be {_AXES_CHOICES}, got {value!r}")
    return tuple(value)


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidTaskError(f"{name} must be a number, got {value!r}")
    return float(value)


def _whole(name: str, value: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise InvalidTaskError(f"{name} must be a whole number, got {value!r}")
    return value


def _lengths(name: str, value: Any) -> FloatArray:
    """Return one length for all bellows, or one for each [m], shape (9,)."""
    if isinstance(value, list | tuple):
        return vector(name, value, bellows.COUNT)
    return np.full(bellows.COUNT, _number(name, value))
