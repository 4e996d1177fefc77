"""The tables of the learner on the trunk: short real runs, and summaries with known answers."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.engine.experiment import Experiment, Figures, Run
from benchmarks.engine.plain_json import round_trip
from benchmarks.trunk import bha_2d, bha_3d, bha_feedback, bha_range, bha_use
from benchmarks.trunk.bha_learning import MINUTES
from benchmarks.trunk.bha_range import DISTURBANCES, disturbances, paused
from benchmarks.trunk.bha_runs import BODY, GRADIENT, METHODS, RLS, task_of
from bha_common import bellows
from bha_goal_babbling.task import find_task

TABLES = [module.EXPERIMENT for module in (bha_2d, bha_3d, bha_feedback, bha_range, bha_use)]


@cache
def short(name: str) -> tuple[Run, ...]:
    """Return quick runs of one robot, as they are read back from disk."""
    experiment = next(each for each in TABLES if each.name == name)
    return tuple(
        Run(1000, settings, round_trip(experiment.run(1000, **settings)))
        for settings in experiment.plan(True)
        if settings.get("method") not in (RLS, GRADIENT)
        and settings.get("disturbance") != "nothing"
    )


@pytest.mark.parametrize("name", ["bha-3d", "bha-range"])
def test_table_comes_of_short_runs(name: str) -> None:
    experiment = next(each for each in TABLES if each.name == name)
    runs = list(short(name))
    summary = experiment.summarise(runs)
    assert summary.rows
    assert all(row.keys() == summary.rows[0].keys() for row in summary.rows)
    # A quick run is too short to tell.
    assert summary.bounds
    assert all(bound.measured is None and not bound.holds for bound in summary.bounds)
    figure = Figure()
    experiment.draw(runs, figure)
    assert any(axes.has_data() for axes in figure.axes)


@pytest.mark.parametrize("experiment", TABLES, ids=lambda experiment: experiment.name)
def test_quick_and_full_plans_take_the_same_settings(experiment: Experiment) -> None:
    names = {frozenset(settings) for quick in (True, False) for settings in experiment.plan(quick)}
    assert len(names) == 1
    assert all(settings == round_trip(settings) for settings in experiment.plan(False))


def test_drift_that_is_paused_stays_where_it_came_to() -> None:
    wrong = disturbances("drifting potentiometer", np.random.default_rng(0))
    still = paused(wrong, 900.0)
    assert np.array(still.sensor_shift) == pytest.approx(900.0 * np.array(wrong.sensor_drift))
    assert max(still.sensor_shift) == pytest.approx(0.009)
    assert not any(still.sensor_drift)
    leak = disturbances("leak", np.random.default_rng(0))
    assert paused(leak, 900.0) == leak


def learned(method: str, errors: dict[float, float], seed: int = 1000, size: int = 2) -> Run:
    """Return a full run whose tip missed every goal by `errors` [m] along the last axis."""
    goals = np.array([[0.0, 0.0, 0.8], [0.3, 0.0, 0.7]])
    offsets = np.zeros((len(MINUTES), len(goals), size))
    for index, minute in enumerate(MINUTES):
        offsets[index, :, -1] = errors.get(minute, 0.005)
    figures: Figures = {
        "minutes": MINUTES,
        "goals [m]": goals,
        "offsets [m]": offsets,
        "movements": 1,
        "samples": 1,
        "maps": 1,
    }
    return Run(seed, {"method": method}, round_trip(figures))


def held(experiment: Experiment, runs: list[Run]) -> list[bool]:
    return [bound.holds for bound in experiment.summarise(runs).bounds]


def test_an_error_that_comes_back_breaks_a_bound_of_2d() -> None:
    good = [learned(method, {}) for method in METHODS]
    assert all(held(bha_2d.EXPERIMENT, good))
    for minute, place in ((30.0, 0), (60.0, 2), (90.0, 4)):
        bad = [learned(BODY, {minute: 0.011}), learned(GRADIENT, {})]
        expected = [True] * 6
        expected[place] = False
        assert held(bha_2d.EXPERIMENT, bad) == expected


def test_one_bad_robot_breaks_a_bound_though_the_mean_is_good() -> None:
    runs = [learned(BODY, {}, seed) for seed in range(1000, 1009)]
    runs.append(learned(BODY, {60.0: 0.016, 90.0: 0.013}, 1009))
    assert held(bha_2d.EXPERIMENT, runs) == [True, True, True, False, True, False]
    assert held(bha_3d.EXPERIMENT, runs) == [True, False, False]


def test_directions_of_an_error_along_z() -> None:
    row = bha_3d.EXPERIMENT.summarise([learned(BODY, {5.0: 0.008}, size=3)]).rows[0]
    assert row["along x [mm]"] == 0.0
    assert row["along z [mm]"] == pytest.approx(8.0)
    tilted = 0.7 / np.hypot(0.3, 0.7)  # share of z that points away from the base, second goal
    assert row["away from the base [mm]"] == pytest.approx(8.0 * (1.0 + tilted) / 2.0)


@pytest.mark.parametrize("name", DISTURBANCES)
def test_a_disturbance_is_on_as_many_bellows_as_said(name: str) -> None:
    field, value, count = DISTURBANCES[name]
    given = getattr(disturbances(name, np.random.default_rng(0)), field)
    if count:
        assert sum(bool(one) for one in given) == count
        assert len(given) == bellows.COUNT
        assert max(given) == pytest.approx(value)
    else:
        assert given == pytest.approx(value)


def recovered(name: str, end: float) -> Run:
    figures = {
        "minutes": [0.0, 15.0],
        "before [m]": 0.01,
        "learning [m]": [0.05, end],
        "frozen [m]": [0.05, 0.05],
    }
    return Run(1000, {"disturbance": name}, figures)


def test_what_is_not_rediscovered_breaks_its_bound() -> None:
    runs = [recovered("leak", 0.0129), recovered("payload", 0.0131)]
    summary = bha_range.EXPERIMENT.summarise(runs)
    assert [bound.holds for bound in summary.bounds] == [True, False]
    assert summary.rows[0]["frozen, at the end [mm]"] == pytest.approx(50.0)


def test_use_that_teaches_nothing_useful_breaks_its_bound() -> None:
    errors = {"nothing": 0.010, "offsets": 0.009, "everything": 0.0079}

    def runs(**changes: float) -> list[Run]:
        size = {"learned": 30.0, "blocks": 6, "block": 25}
        return [
            Run(
                1000,
                {"case": settings["case"], "learns": settings["learns"], **size},
                {
                    "errors [m]": [0.02] * 5 + [(errors | changes)[settings["learns"]]],
                    "minutes": [30.0],
                    "examples": 600,
                },
            )
            for settings in bha_use.EXPERIMENT.plan(False)
        ]

    assert held(bha_use.EXPERIMENT, runs()) == [True] * 4
    assert held(bha_use.EXPERIMENT, runs(everything=0.0081)) == [True, False, True, True]
    assert held(bha_use.EXPERIMENT, runs(offsets=0.0101)) == [True, True, False, False]


def corner(**changes: float) -> dict[str, Any]:
    movement = {"feed-forward [m]": 0.01, "at the end [m]": 0.002, "swing [m]": 0.002}
    return {**bha_feedback.CORNERS[0], **movement, **changes}


@pytest.mark.parametrize(
    ("changes", "stable"),
    [({}, True), ({"swing [m]": 0.02}, False), ({"at the end [m]": 0.02}, False)],
)
def test_a_movement_that_swings_or_runs_away_is_counted(
    changes: dict[str, float], stable: bool
) -> None:
    run = Run(1000, {"part": "corners"}, {"movements": [corner(**changes)]})
    (bound,) = bha_feedback.EXPERIMENT.summarise([run]).bounds
    assert bound.holds == stable
    assert bound.measured == (0 if stable else 1)


def test_feedback_is_held_against_the_repetition_of_the_same_robot() -> None:
    def robot(seed: int, feedback: float, repetition: float) -> Run:
        settings = {"part": "exactness", "space": "2d", "minutes": 60.0}
        figures = {
            "feed-forward [m]": [0.008, 0.008],
            "feedback [m]": [feedback, feedback],
            "durations [s]": [20.0, 30.1],
            "arrived": [True, False],
            "repetition [m]": repetition,
        }
        return Run(seed, settings, figures)

    assert held(bha_feedback.EXPERIMENT, [robot(0, 0.003, 0.005)]) == [True, True, True]
    assert held(bha_feedback.EXPERIMENT, [robot(0, 0.003, 0.003)]) == [True, False, True]
    assert held(bha_feedback.EXPERIMENT, [robot(0, 0.0041, 0.005)]) == [False, True, True]


def test_methods_differ_from_the_task_file_in_their_settings_alone() -> None:
    own, rls, gradient = (task_of("3d", method) for method in METHODS)
    assert own.config == find_task("3d").config
    assert (own.config.model, own.config.forward_model) == ("recursive_maps", "polynomial")
    assert (rls.config.model, rls.config.forward_model) == ("recursive_maps", "none")
    assert (gradient.config.model, gradient.config.forward_model) == ("local_linear_maps", "none")
    assert np.array_equal(own.goals(), gradient.goals())
