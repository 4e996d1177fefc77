"""The table `bha-plant`: what is made of measurements, and measurements with known answers."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.engine.experiment import Run
from benchmarks.trunk import plant_properties, plant_sensors
from benchmarks.trunk.bha_plant import EXPERIMENT, plan, run
from benchmarks.trunk.plant_drives import task_grid
from benchmarks.trunk.plant_table import PROPERTIES, Property, Robot
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters

QUICK = {"scale": 0.02}


def measured(robot: int, repetition: float = 0.005) -> Robot:
    """Return what a robot might have measured, at full length."""
    ends = np.array([np.linspace(0.15, 0.16, 9), np.linspace(0.26, 0.29, 9)])
    goals = task_grid()
    shells = {
        f"reach {radius:g}": goals[np.isclose(np.linalg.norm(goals, axis=1), radius)]
        for radius in (0.735, 0.78, 0.825)
    }
    return {
        "settling": {"median [s]": 12.0 + robot, "p90 [s]": 20.0, "curve [m]": [0.1, 0.01, 0.001]},
        "repetition": {
            "tip [m]": repetition,
            "measured lengths [m]": 1e-4,
            "true lengths [m]": 4e-4,
        },
        "repetition, ideal cables": {
            "tip [m]": 4e-4,
            "measured lengths [m]": 1e-4,
            "true lengths [m]": 1e-4,
        },
        "memory": {"largest distance [m]": 0.03, "distance from the mean [m]": 0.01},
        "ranges": {
            "ends [m]": ends.tolist(),
            "ends an hour later [m]": (ends + np.array([[0.02], [0.01]])).tolist(),
        },
        "curvature": {"mean [m]": 0.009, "largest [m]": 0.02},
        "twist": {"largest [rad]": 0.1},
        "pneumatics": {
            "dead time [s]": 0.06,
            "lag of filling [s]": 0.25,
            "lag of venting [s]": 0.35,
            "play of the regulators [Pa]": 500.0,
        },
        "potentiometers": {
            "noise [m]": 5e-4,
            "step [m]": 2.5e-4,
            "drift in an hour [m]": 2e-3,
            "play [m]": 7e-4,
            "offsets [m]": [0.0] * 9,
        },
        "speed": {"times real time, median": 300.0},
        "draw": {
            "stiffnesses": 0.14,
            "areas": 0.09,
            "friction": 0.14,
            "creep": 0.14,
            "masses": 0.14,
            "sensor offsets [m]": 0.0028,
        },
    } | {
        name: {"goals [m]": shell.tolist(), "errors [m]": [0.008] * (len(shell) - 7) + [0.02] * 7}
        for name, shell in shells.items()
    }


def runs_of(robots: list[Robot], scale: float = 1.0) -> list[Run]:
    return [
        Run(1000 + number, {"measurement": name, "scale": scale}, figures)
        for number, robot in enumerate(robots)
        for name, figures in robot.items()
    ]


def test_every_property_is_a_row_and_every_demand_a_bound() -> None:
    summary = EXPERIMENT.summarise(runs_of([measured(0), measured(1), measured(2)]))
    assert [row["property"] for row in summary.rows] == [entry.name for entry in PROPERTIES]
    assert len(summary.bounds) == sum(entry.bounded for entry in PROPERTIES)
    assert all(bound.holds for bound in summary.bounds)
    first = summary.rows[0]
    assert (first["mean"], first["lowest robot"], first["highest robot"]) == (13.0, 12.0, 14.0)
    assert first["robots within"] == "3 of 3"
    grid = next(row for row in summary.rows if row["property"].startswith("task grid"))
    assert grid["mean"] == pytest.approx(100.0 * (1.0 - 21 / 315))
    lower = next(row for row in summary.rows if row["property"].startswith("lower ends"))
    assert lower["mean"] == pytest.approx(np.mean(100 * 0.02 / np.linspace(0.11, 0.13, 9)))


@pytest.mark.parametrize(("repetition", "holds"), [(0.0039, False), (0.0041, True), (0.007, False)])
def test_bounds_are_held_against_the_mean_of_the_robots(repetition: float, holds: bool) -> None:
    robots = [measured(0, repetition - 0.001), measured(1, repetition + 0.001)]
    summary = EXPERIMENT.summarise(runs_of(robots))
    bound = next(each for each in summary.bounds if each.what.startswith("repetition accuracy"))
    assert bound.bound == "4 to 6"
    assert bound.measured == pytest.approx(1e3 * repetition)
    assert bound.holds == holds


def test_quick_runs_hold_no_bound() -> None:
    summary = EXPERIMENT.summarise(runs_of([measured(0)], scale=0.02))
    assert all(bound.measured is None and not bound.holds for bound in summary.bounds)


def test_the_plan_measures_what_the_table_needs() -> None:
    assert {settings["measurement"] for settings in plan(False)} == measured(0).keys()
    assert all(settings["scale"] == 1.0 for settings in plan(False))


def test_the_figure_shows_every_part() -> None:
    figure = Figure()
    EXPERIMENT.draw(runs_of([measured(0), measured(1)]), figure)
    assert len(figure.axes) == 4
    assert all(axes.has_data() for axes in figure.axes)


@pytest.mark.parametrize("measurement", ["draw", "pneumatics", "speed", "curvature"])
def test_a_run_brings_what_the_table_reads(measurement: str) -> None:
    figures = run(3, measurement=measurement, **QUICK)
    assert figures.keys() == measured(0)[measurement].keys()
    json.dumps(figures)


def test_runs_are_repeatable() -> None:
    first, again = (run(3, measurement="curvature", **QUICK) for _ in range(2))
    assert first == again


def test_the_demand_in_words() -> None:
    def value(robot: Robot) -> float:
        return 1.0

    assert Property("p", value, 4, 6).demand == "4 to 6"
    assert Property("p", value, 20).demand == ">= 20"
    assert Property("p", value, high=9).demand == "<= 9"
    assert Property("p", value).demand == ""
    assert Property("p", value, 4, 6).within(np.array([3.9, 4.0, 6.0, 6.1])).tolist() == [
        False,
        True,
        True,
        False,
    ]


def plant(**potentiometers: Any) -> Plant:
    robot = draw_robot(load_parameters(), 0)
    return Plant(
        replace(robot, potentiometers=replace(robot.potentiometers, **potentiometers)), seed=0
    )


def test_pneumatics_are_seen_as_they_are_in_the_file() -> None:
    robot = plant()
    figures = plant_sensors.pneumatics(robot, np.random.default_rng(0), 1.0)
    parameters = robot.parameters.pneumatics
    assert figures["dead time [s]"] == pytest.approx(0.06, abs=0.005)
    assert figures["lag of filling [s]"] == pytest.approx(
        parameters.fill_time_constant.mean(), abs=0.02
    )
    assert figures["lag of venting [s]"] == pytest.approx(
        parameters.vent_time_constant.mean(), abs=0.02
    )
    assert figures["play of the regulators [Pa]"] == pytest.approx(500.0, abs=20.0)


def test_potentiometers_are_seen_as_they_are_in_the_file() -> None:
    robot = plant(drift_spread=0.0, play=1e-3, noise=4e-4, resolution=2e-4)
    figures = plant_sensors.potentiometers(robot, np.random.default_rng(0), 0.02)
    assert figures["noise [m]"] == pytest.approx(np.hypot(4e-4, 2e-4 / np.sqrt(12)), rel=0.05)
    assert figures["step [m]"] == pytest.approx(2e-4)
    assert figures["play [m]"] == pytest.approx(1e-3, abs=1e-4)
    assert figures["drift in an hour [m]"] < 5e-5
    offsets = robot.parameters.potentiometers.offsets
    gains = robot.parameters.potentiometers.gains
    np.testing.assert_allclose(figures["offsets [m]"], offsets + (gains - 1.0) * 0.25, atol=1e-3)


def test_drift_is_seen() -> None:
    quiet, drifting = (
        plant_sensors.potentiometers(
            plant(drift_spread=spread, drift_time=60.0), np.random.default_rng(0), 0.1
        )["drift in an hour [m]"]
        for spread in (0.0, 1e-3)
    )
    assert drifting > 10 * quiet
    assert 1e-3 < drifting < 6e-3


def test_a_goal_out_of_reach_is_not_reached() -> None:
    goals = np.array([[0.0, 0.0, 0.85], [0.0, 0.0, 0.4]])
    near, far = plant_properties.reach(plant(), goals)["errors [m]"]
    assert near < 0.010
    assert far > 0.1
