"""The table `bha-control`: what it counts, on models and controllers of known numbers."""

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.engine.experiment import Bound, Run
from benchmarks.trunk import bha_control
from benchmarks.trunk.equilibrium_models import CONSTRAINED, MODELS, THIRD, USUAL, violations
from benchmarks.trunk.length_control_methods import (
    LEARNED,
    METHODS,
    PID_CAREFUL,
    PID_FAST,
    Pid,
    controller,
)
from benchmarks.trunk.length_responses import (
    PERIOD,
    identified,
    is_stable,
    new_plant,
    resting,
    steps,
)
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel

SLOPE = 1.2e6 * np.eye(9)
MODEL = EquilibriumModel.affine(np.full(9, 0.22), np.full(9, 6.5e4), SLOPE)
TARGETS = [np.full(9, 0.22), 0.22 + 0.03 * np.cos(np.arange(9.0)), np.full(9, 0.21)]


class State:
    def __init__(self, lengths: np.ndarray, noise: np.ndarray) -> None:
        self.true_lengths, self.lengths = lengths, lengths + noise + 0.002
        self.tip = 5.0 * lengths[:3]


class LaggingPlant:
    """Bellows with a dead time of two periods and a lag, whose readings are 2 mm off and noisy."""

    def __init__(self, stiffness: float = 1.0) -> None:
        self._rng, self._stiffness = np.random.default_rng(0), stiffness
        self._waiting = [np.full(9, 6.5e4)] * 2
        self.state = State(np.full(9, 0.22), np.zeros(9))

    def step(self, pressures: np.ndarray) -> State:
        self._waiting.append(pressures)
        rest = 0.22 + (self._waiting.pop(0) - 6.5e4) / (1.2e6 * self._stiffness)
        lengths = self.state.true_lengths + 0.06 * (rest - self.state.true_lengths)
        self.state = State(lengths, 5e-4 * self._rng.standard_normal(9))
        return self.state


def test_violations_are_those_of_the_model() -> None:
    """A slope of the wrong sign falls everywhere; without ends half of all places are out."""
    assert violations(MODEL, 0)["falling"] == violations(MODEL, 0)["outside"] == 0.0
    assert violations(MODEL, 0)["certain"] == pytest.approx(1.2)
    free = EquilibriumModel.affine(np.full(9, 0.22), np.full(9, 6.5e4), -SLOPE, constrained=False)
    told = violations(free, 0)
    assert told["falling"] == 100.0
    assert told["outside"] > 99.0
    assert told["lowest"] == pytest.approx(-1.2)


def test_steps_are_measured_without_noise_and_offset() -> None:
    """A PID brings it there; settling of a lag, and neither offset nor noise as error."""
    told: Any = steps(LaggingPlant(), Pid(4e5, 2.5e6), TARGETS)  # type: ignore[arg-type]
    assert all(0.3 < time < 4.0 for time in told["all within"])
    assert all(
        rms <= every for rms, every in zip(told["rms within"], told["all within"], strict=True)
    )
    slow: Any = steps(LaggingPlant(), Pid(4e4, 1e5), TARGETS)  # type: ignore[arg-type]
    assert max(slow["all within"]) == 8.0


def test_overshoot_is_told() -> None:
    swinging: Any = steps(LaggingPlant(), Pid(1e5, 6e6), TARGETS)  # type: ignore[arg-type]
    calm: Any = steps(LaggingPlant(), Pid(4e5, 1e6), TARGETS)  # type: ignore[arg-type]
    assert min(swinging["overshoot"]) > 3.0
    assert max(calm["overshoot"]) < 1.0


def test_stability_is_told() -> None:
    plant: Any = LaggingPlant()
    assert is_stable(plant, lambda: Pid(8e5, 5e6), TARGETS)
    assert not is_stable(plant, lambda: Pid(2e7, 5e6), TARGETS)


def test_the_motion_at_rest_is_told() -> None:
    """What noise and gains make of it, not where it is."""
    moved = [
        resting(LaggingPlant(), Pid(gain, 0.0), TARGETS)  # type: ignore[arg-type]
        for gain in (0.0, 4e5, 1.6e6)
    ]
    assert moved[0] < 0.1
    assert moved[2] > 2.0 * moved[1] > 0.2


@pytest.mark.parametrize("seed", [0, 7])
def test_lags_of_the_simulated_robot_are_identified(seed: int) -> None:
    """From lengths alone, and near those that were drawn for its nine valves."""
    plant = new_plant(seed)
    found, known = identified(plant, 30, seed)[0].dynamics, plant.parameters.pneumatics
    # A command acts in the period after it was told.
    assert found.dead_time == pytest.approx(known.dead_time + PERIOD, abs=0.02)
    assert found.fill_lag == pytest.approx(np.mean(known.fill_time_constant), rel=0.15)
    assert found.vent_lag == pytest.approx(np.mean(known.vent_time_constant), rel=0.15)
    assert found.response_lag == 0.0


@pytest.mark.parametrize("method", METHODS)
def test_every_method_makes_pressures(method: str) -> None:
    pressures = controller(method, MODEL).update(TARGETS[1], TARGETS[0])
    assert pressures.shape == (9,)
    assert ((pressures >= 0.0) & (pressures <= 1.3e5)).all()


def made(**changes: float) -> list[Run]:
    """Return invented runs of two robots."""
    model = {"error": 5.0, "falling": 0.0, "outside": 0.0, "lowest": 0.3, "certain": 0.2}
    usual = {**model, "falling": 1.0, "lowest": -0.1}
    fits = {name: usual if name == USUAL else model for name in MODELS}
    fits[CONSTRAINED] = {**fits[CONSTRAINED], "falling": changes.get("falling", 0.0)}
    models = {on: {"time": 600.0, **fits} for on in ("30", "60", "120", "240", THIRD)}
    responses: dict[str, Any] = {}
    for method in METHODS:
        settled = {LEARNED: 0.8, PID_CAREFUL: 2.0}.get(method, 3.0)
        names = ("all within", "rms within", "overshoot", "mean overshoot", "rms")
        responses[method] = {name: [settled] for name in names}
        responses[method] |= {
            "tracking": 1.0,
            "resting": 1.2,
            "margin of 2": changes.get("stable", 1.0) > 0.0,
        }
    age = {"hours": [0.5, 3.0], "fitted": [5.0, 9.0], "adapted": [5.0, 5.0], "still rises": True}
    parts = {"models": models, "responses": responses, "age": age}
    return [Run(seed, {"part": part}, parts[part]) for seed in (0, 1) for part in parts]


def bound(runs: list[Run], word: str) -> Bound:
    return next(each for each in bha_control.summarise(runs).bounds if word in each.what)


def test_bounds_follow_the_runs() -> None:
    assert all(each.holds for each in bha_control.summarise(made()).bounds)
    assert bound(made(), PID_CAREFUL).measured == pytest.approx(2.5)
    assert bound(made(), PID_FAST).measured == pytest.approx(3.75)
    assert not bound(made(falling=0.1), "violations").holds
    assert not bound(made(stable=0.0), "stable").holds
    assert bound(made(), "unconstrained ELMs").measured == 100.0


def test_rows_share_their_columns_and_the_figure_shows_something() -> None:
    rows = bha_control.summarise(made()).rows
    assert len(rows) == 5 * len(MODELS) + len(METHODS) + 4
    assert all(row.keys() == rows[0].keys() for row in rows)
    figure = Figure()
    bha_control.draw(made(), figure)
    assert len(figure.axes) == 3
    assert all(axes.has_data() for axes in figure.axes)
