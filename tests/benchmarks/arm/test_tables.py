"""Every table: its runs, its rows and bounds, its figure."""

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.arm import branches, drift, linear, non_convex, toy
from benchmarks.engine.experiment import Experiment, Run
from benchmarks.engine.plain_json import round_trip
from bha_goal_babbling.planar_arm import PlanarArm

SHORT: dict[str, list[dict[str, Any]]] = {
    "linear": [
        {"part": "gradients", "problems": 20},
        {"part": "ignition", "rate": 0.02, "spread": 0.4, "samples": 1000},
        {"part": "end", "spread": 1.5, "rates": [4e-4], "samples": [300]},
    ],
    "toy": [{"snapshots": [5, 20]}],
    "branches": [{"joints": 2, "branch": branch, "movements": 60} for branch in (1, -1)],
    "drift": [
        {"joints": 3, "method": settings["method"], "movements": 20}
        for settings in drift.plan(True)
    ],
    "non-convex": [
        {"joints": 2, "method": settings["method"], "movements": 60}
        for settings in non_convex.plan(True)
    ],
}
TABLES = [module.EXPERIMENT for module in (linear, toy, branches, drift, non_convex)]


def made(experiment: Experiment) -> list[Run]:
    """Return short runs of two seeds, as they are read back from disk."""
    return [
        Run(seed, settings, round_trip(experiment.run(seed, **settings)))
        for seed in (0, 1)
        for settings in SHORT[experiment.name]
    ]


@pytest.mark.parametrize("experiment", TABLES, ids=lambda experiment: experiment.name)
def test_table_comes_of_runs(experiment: Experiment) -> None:
    """Rows share their columns, every bound is told, the figure shows something."""
    runs = made(experiment)
    summary = experiment.summarise(runs)
    assert summary.rows
    assert all(row.keys() == summary.rows[0].keys() for row in summary.rows)
    assert summary.bounds
    round_trip(summary.rows)
    figure = Figure()
    experiment.draw(runs, figure)
    assert all(axes.has_data() for axes in figure.axes)


@pytest.mark.parametrize("experiment", TABLES, ids=lambda experiment: experiment.name)
@pytest.mark.parametrize("quick", [True, False])
def test_planned_runs_are_those_that_run_takes(experiment: Experiment, quick: bool) -> None:
    """The settings of the short runs here have the names of the planned ones."""
    planned = [set(settings) for settings in experiment.plan(quick)]
    assert all(set(settings) in planned for settings in SHORT[experiment.name])


def test_bounds_follow_the_runs() -> None:
    """An inner product below zero in one run, and the bound does not hold."""
    runs = made(linear.EXPERIMENT)
    assert linear.summarise(runs).bounds[0].holds
    runs[0].figures["inner_products"][3] = -0.5
    bound = linear.summarise(runs).bounds[0]
    assert (bound.measured, bound.holds) == (-0.5, False)


def test_short_runs_cannot_tell_the_end() -> None:
    """What needs the full length is not measured, and does not count as reached."""
    for experiment, number in ((linear.EXPERIMENT, 1), (toy.EXPERIMENT, 0), (drift.EXPERIMENT, 0)):
        bound = experiment.summarise(made(experiment)).bounds[number]
        assert (bound.measured, bound.holds) == (None, False)


def test_visited_share_counts_cells_once() -> None:
    """Two of 4 x 4 cells; the border belongs to the outermost."""
    actions = np.array([[0.1, 0.1], [0.2, 0.3], [np.pi, np.pi]])
    assert toy.visited_share(actions, np.pi / 2) == 2 / 16


def test_angle_between_lines() -> None:
    assert toy.angle_between(np.array([1.0, 0.0]), np.array([-1.0, 1.0])) == pytest.approx(45.0)


@pytest.mark.parametrize("joints", [2, 3, 20])
def test_side_tells_the_two_homes(joints: int) -> None:
    arm = PlanarArm(joints)
    postures = np.stack([arm.home(branch=1), arm.home(branch=-1)])
    np.testing.assert_array_equal(branches.side(postures), [1, -1])


def test_direct_fit_averages_two_solutions() -> None:
    """Elbow up and elbow down average to a stretched arm, which overshoots the goal."""
    maps = non_convex.fit_random_data(2, 8_000, np.random.default_rng(0))
    goal = np.array([0.5, 0.0])
    postures = maps.predict(goal)
    assert abs(postures[1]) < 1.0  # both solutions have it at 2.1
    assert np.linalg.norm(PlanarArm(2).forward(postures) - goal) > 0.2
