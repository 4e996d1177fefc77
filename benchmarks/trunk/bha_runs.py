"""What the tables of the learner on the trunk share: robots that learn, goals, and errors."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bha_bringup.in_process import InProcessRobot
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.task import Task, find_task

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

BODY = "RLS goal babbling with a body model"
RLS, GRADIENT = "RLS goal babbling", "goal babbling"
METHODS = (BODY, RLS, GRADIENT)
COLOURS = {BODY: "#0072b2", RLS: "#009e73", GRADIENT: "#d55e00"}

_GRADIENT: dict[str, Any] = {
    "forward_model": "none",
    "model": "local_linear_maps",
    "learning_rate": 0.6,
    "efficiency": "plain",
    "efficiency_limit": 1.0,
    "noise_spread": 0.007,
    "noise_step": 0.007,
    "noise_per_error": None,
    "path_steps": 10,
    "goal_candidates": 1,
    "abort_distance": None,
    "stay_steps": 0,
    "rest_error": 0.0,
}
"""The article's method as it did best on robots 0 to 2: what differs from the task files."""


_CHANGES: dict[str, dict[str, Any]] = {
    BODY: {},
    RLS: {"forward_model": "none"},
    GRADIENT: _GRADIENT,
}


def task_of(space: str, method: str = BODY) -> Task:
    """Return a task of the trunk, to be learned by one of `METHODS`; as it comes by the first."""
    task = find_task(space)
    changed = dataclasses.replace(task.config, **_CHANGES[method])
    return dataclasses.replace(task, config=changed)


def held_out(task: Task, seed: int, count: int) -> Array:
    """Return goals that are no goals of the babbling [m], shape (count, 3)."""
    return task.held_out_positions(count, np.random.default_rng([seed, 1]))


def offsets(robot: InProcessRobot, goals: Array) -> Array:
    """Go to goals (N, 3) [m] feed-forward; tip less goal at the end [m], shape (N, n).

    It is the true tip, whatever the tracker sees.
    """
    task = robot.learner.task
    rows = []
    for goal in goals:
        robot.reach(goal)
        rows.append(task.outcome(robot.plant.state.tip) - task.outcome(goal))
    return np.array(rows)


def errors(robot: InProcessRobot, goals: Array) -> Array:
    """Go to goals (N, 3) [m] feed-forward; distances of the tip at the end [m], shape (N,)."""
    return np.asarray(np.linalg.norm(offsets(robot, goals), axis=1))


def frozen_errors(robot: InProcessRobot, goals: Array, frozen: SavedState) -> Array:
    """Return the same with what was learned before, and go on with what the robot has learned.

    Every goal is answered by what was known then, offsets of the sensors included.
    """
    learned, time = robot.learner.babbler, robot.learner.exploration_time
    assert learned is not None
    found = []
    for goal in goals:
        robot.learner.use(GoalBabbler.restore(frozen))
        found.append(errors(robot, goal[np.newaxis])[0])
    robot.learner.use(learned, time)
    return np.array(found)


def learned_by(robot: InProcessRobot) -> SavedState:
    """Return what the robot has learned so far."""
    babbler = robot.learner.babbler
    assert babbler is not None
    return babbler.state()


def draw_spread(axes: Axes, x: Sequence[float], values: Array, colour: str, label: str) -> None:
    """Draw the mean of robots (rows of values) over x, and the range of the robots."""
    axes.plot(x, values.mean(axis=0), color=colour, marker="o", markersize=3, label=label)
    axes.fill_between(x, values.min(axis=0), values.max(axis=0), color=colour, alpha=0.15)
