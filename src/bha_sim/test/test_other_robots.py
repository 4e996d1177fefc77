"""Plants of other parameter files: they run, or say what cannot be."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from bha_sim.errors import PlantDivergedError, RobotParameterError
from bha_sim.plant import Plant
from bha_sim.plant_state import PlantState
from bha_sim.robot_parameters import draw_robot, load_parameters

FILE = Path(__file__).resolve().parents[1] / "config" / "robot.yaml"


def other(folder: Path, **changes: dict[str, Any]) -> Plant:
    """Make a plant of a changed file; a section is changed entry by entry."""
    data = copy.deepcopy(yaml.safe_load(FILE.read_text(encoding="utf-8")))
    for section, entries in changes.items():
        data[section].update(entries)
    path = folder / "other.yaml"
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return Plant(draw_robot(load_parameters(path), 0), seed=0)


def exercise(robot: Plant) -> PlantState:
    """Go through some postures, and end at full pressure."""
    top = robot.parameters.pneumatics.max_pressure
    rng = np.random.default_rng(0)
    for pressures in [*rng.choice([0.0, top], (8, 9)), np.full(9, top)]:
        for _ in range(100):
            robot.step(pressures)
    return robot.state


@pytest.mark.parametrize(
    "changes",
    [
        {"bellows": {"stiffness": 270.0}},
        {"bellows": {"stiffness": [1080.0, 800.0, 540.0]}},
        {"trunk": {"segment_masses": [2.0, 1.5, 1.0], "tool_mass": 0.5}},
        {"trunk": {"gravity": 0.0}},
        {"trunk": {"discs_per_segment": 1}, "bellows": {"disc_profile": [1.0]}},
        {"trunk": {"discs_per_segment": 5}, "bellows": {"disc_profile": [1.5, 1.2, 1, 0.8, 0.5]}},
        {
            "relaxation": {"time_constants": [], "shares": []},
            "hysteresis": {"slips": [], "shares": []},
        },
        {"relaxation": {"time_constants": [1.0, 8.0, 60.0, 600.0], "shares": [0.2] * 4}},
        {"pneumatics": {"dead_time": 0.0, "regulator_play": 0.0, "fill_time_constant": 1.0}},
        {"potentiometers": {"resolution": 0.0, "noise": 0.002, "offsets": [0.01, 0.0, -0.01]}},
    ],
    ids=lambda changes: ", ".join(name for section in changes.values() for name in section),
)
def test_other_robots_work(tmp_path, changes):
    state = exercise(other(tmp_path, **changes))
    for values in (state.lengths, state.pressures, state.tip, state.true_lengths):
        assert np.isfinite(values).all()
    assert np.all((state.true_lengths > 0.15) & (state.true_lengths < 0.45))
    np.testing.assert_allclose(state.lengths, state.true_lengths, atol=0.03)


def test_softer_bellows_reach_further(tmp_path):
    soft = exercise(other(tmp_path, bellows={"stiffness": 400.0}))
    stiff = exercise(other(tmp_path, bellows={"stiffness": 800.0}))
    assert np.all(soft.true_lengths > stiff.true_lengths + 0.02)


@pytest.mark.parametrize(
    "changes",
    [{"trunk": {"damping_time": 0.001}}, {"bellows": {"hardening": 4e6}}],
    ids=["undamped", "hard"],
)
def test_a_trunk_that_cannot_hang_is_refused(tmp_path, monkeypatch, changes):
    monkeypatch.chdir(tmp_path)  # MuJoCo leaves a log file where it runs
    with pytest.raises(
        RobotParameterError, match=r"does not hang at rest: .*mjWARN.*max_time_step .*damping_time"
    ):
        other(tmp_path, **changes)


def test_bellows_that_push_more_than_the_trunk_holds_are_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(PlantDivergedError, match=r"bellows push \(areas x max_pressure\) more"):
        exercise(other(tmp_path, bellows={"areas": 1e-2}))
