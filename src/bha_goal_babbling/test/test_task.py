"""Tasks: the files that come with the package, held-out goals, messages for wrong entries."""

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from bha_goal_babbling.errors import InvalidTaskError
from bha_goal_babbling.task import Task, load_task

CONFIG = Path(__file__).parents[1] / "config"
FILES = [CONFIG / "task_2d.yaml", CONFIG / "task_3d.yaml"]


def entries() -> dict[str, Any]:
    """Return the entries of the 3-D task."""
    loaded: dict[str, Any] = yaml.safe_load(FILES[1].read_text())
    return loaded


def test_two_dimensions() -> None:
    """The lateral coordinates of the shell of radius 0.78 m."""
    task = load_task(FILES[0])
    assert (task.name, task.axes, task.outcome_size) == ("2d", ("x", "y"), 2)
    goals = task.goals()
    assert goals.shape == (105, 2)
    assert np.linalg.norm(goals, axis=1).max() == pytest.approx(0.78 * np.sin(np.radians(36.0)))


def test_three_dimensions() -> None:
    """All 315 goals of the grid."""
    task = load_task(FILES[1])
    assert (task.name, task.axes, task.outcome_size) == ("3d", ("x", "y", "z"), 3)
    goals = task.goals()
    assert goals.shape == (315, 3)
    radius = np.linalg.norm(goals, axis=1)
    assert (radius.min(), radius.max()) == (pytest.approx(0.735), pytest.approx(0.825))


@pytest.mark.parametrize("path", FILES)
def test_actions_are_nine_lengths(path: Path) -> None:
    """Home and limits, read-only."""
    task = load_task(path)
    assert task.home_action.shape == task.action_low.shape == task.action_high.shape == (9,)
    assert len(set(task.home_action)) == 1
    with pytest.raises(ValueError, match="read-only"):
        task.home_action[0] = 0.0


@pytest.mark.parametrize("path", FILES)
def test_held_out_goals(path: Path) -> None:
    """Inside the region, accepted, apart from the grid, the same for the same seed."""
    task = load_task(path)
    goals = task.held_out_goals(200, np.random.default_rng(0))
    assert goals.shape == (200, task.outcome_size)
    assert all(task.why_refused(goal, margin=0.0) is None for goal in goals)
    gaps = np.linalg.norm(goals[:, np.newaxis] - task.goals(), axis=2)
    assert gaps.min() > 1e-3
    np.testing.assert_array_equal(goals, task.held_out_goals(200, np.random.default_rng(0)))
    positions = task.held_out_positions(200, np.random.default_rng(0))
    np.testing.assert_array_equal(task.outcome(positions), goals)
    assert not np.array_equal(goals, task.held_out_goals(200, np.random.default_rng(1)))


@pytest.mark.parametrize("path", FILES)
def test_goals_are_refused_with_a_reason(path: Path) -> None:
    """Goals of the grid pass; far ones, NaN and wrong shapes do not."""
    task = load_task(path)
    assert all(task.why_refused(goal, margin=0.0) is None for goal in task.goals())
    assert "m" in str(task.why_refused(np.full(task.outcome_size, 0.7)))
    assert "finite" in str(task.why_refused(np.full(task.outcome_size, np.nan)))
    assert "shape" in str(task.why_refused(np.zeros(4)))


def test_outcome_takes_the_coordinates_that_count() -> None:
    """One tip or many."""
    task = load_task(FILES[0])
    np.testing.assert_array_equal(task.outcome([1.0, 2.0, 3.0]), [1.0, 2.0])
    assert task.outcome(np.zeros((7, 3))).shape == (7, 2)


def test_lengths_for_every_bellows() -> None:
    """Nine numbers in place of one."""
    given = entries()
    given["home_lengths"] = [0.20, 0.21, 0.22] * 3
    given["length_limits"] = [[0.15] * 9, 0.3]
    task = Task.from_mapping(given)
    np.testing.assert_array_equal(task.home_action, given["home_lengths"])
    np.testing.assert_array_equal(task.action_low, np.full(9, 0.15))


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (("axes",), ["x", "z"], "axes must be"),
        (("axes",), "xy", "axes must be"),
        (("axes",), 3, "axes must be"),
        (("goals",), 3, "goals must hold"),
        (("goals", "radii"), [0.8, 0.7], "radii must be rising"),
        (("goals", "radii"), ["a"], "radii"),
        (("goals", "polar_max_degrees"), 120.0, "polar_max"),
        (("goals", "polar_max_degrees"), "wide", "goals.polar_max_degrees must be a number"),
        (("goals", "polar_steps"), 2.5, "goals.polar_steps must be a whole number"),
        (("goals", "extra"), 1, "goals has unknown extra"),
        (("home_lengths",), 0.05, "home_lengths must lie inside length_limits"),
        (("home_lengths",), [0.2] * 8, "home_lengths has shape"),
        (("home_lengths",), None, "home_lengths must be a number"),
        (("length_limits",), 0.3, "length_limits must be"),
        (("length_limits",), [0.1, 320.0], "within 0.1 to 0.4 m, .* got 0.1 to 320"),
        (("length_limits",), [0.01, 0.3], "within 0.1 to 0.4 m"),
        (("goals", "radii"), [780.0], "radii must be at most 2 m, got 780"),
        (("babbler",), None, "babbler must hold settings"),
        (("babbler", "learning_rate"), -1.0, "learning_rate must be"),
        (("babbler", "eta"), 0.3, "unknown setting eta"),
        (("colour",), "red", "unknown colour"),
    ],
)
def test_wrong_entries_are_named(
    tmp_path: Path, place: tuple[str, ...], value: Any, message: str
) -> None:
    """The message names the file, the entry, and what would be right."""
    given = copy.deepcopy(entries())
    owner = given
    for name in place[:-1]:
        owner = owner[name]
    owner[place[-1]] = value
    path = tmp_path / "odd.yaml"
    path.write_text(yaml.safe_dump(given))
    with pytest.raises(InvalidTaskError, match=message) as caught:
        load_task(path)
    assert "odd.yaml" in str(caught.value)


@pytest.mark.parametrize("name", ["name", "axes", "goals", "home_lengths", "babbler"])
def test_missing_entries_are_named(name: str) -> None:
    """Nothing is filled in silently."""
    given = entries()
    del given[name]
    with pytest.raises(InvalidTaskError, match=f"misses {name}"):
        Task.from_mapping(given)


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"", "must hold the entries"), (b"a: [", "YAML"), (b"\xff\xfe\x00", "UTF-8")],
)
def test_unreadable_files(tmp_path: Path, content: bytes, message: str) -> None:
    """Empty, malformed and binary files."""
    path = tmp_path / "task.yaml"
    path.write_bytes(content)
    with pytest.raises(InvalidTaskError, match=message):
        load_task(path)
    with pytest.raises(InvalidTaskError, match="cannot be read"):
        load_task(tmp_path / "nowhere.yaml")
