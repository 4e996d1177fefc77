"""A model of all that identification has seen, on a robot whose every number is known."""

from typing import Any

import numpy as np
import pytest

from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics
from bha_pressure_ctrl.equilibrium_model import Array, EquilibriumModelError
from bha_pressure_ctrl.identification import Identification, IdentificationSettings
from bha_pressure_ctrl.identified_model import fit_identified_model

PERIOD = 0.02
STIFFNESS, CREEPING, CREEP_TIME = 8e5, 2e5, 5.0  # [Pa/m], [Pa/m], [s]: between two of the grid's


class Robot:
    """Valves with dead time and lag, before bellows that creep, with noisy potentiometers."""

    def __init__(self, dead_time: float, fill: float, vent: float, noise: float = 5e-4) -> None:
        self._waiting = [np.zeros(9)] * round(dead_time / PERIOD)
        self._lags = fill, vent
        self._noise, self._rng = noise, np.random.default_rng(0)
        self._pressures, self._crept = np.zeros(9), np.full(9, 0.15)
        self._lengths = np.full(9, 0.15)

    def measure(self) -> Array:
        return self._lengths + self._noise * self._rng.standard_normal(9)

    def step(self, pressures: Array) -> None:
        self._waiting.append(pressures)
        away = self._waiting.pop(0) - self._pressures
        lags = np.where(away > 0.0, *self._lags)
        self._pressures = self._pressures - np.expm1(-PERIOD / lags) * away
        # p = k (l - 0.15) + c (l - crept)
        push = self._pressures + STIFFNESS * 0.15 + CREEPING * self._crept
        self._lengths = push / (STIFFNESS + CREEPING)
        self._crept = self._crept + PERIOD / CREEP_TIME * (self._lengths - self._crept)


def identified(robot: Robot, samples: int = 30, **settings: Any) -> Identification:
    running = Identification(
        IdentificationSettings(**{"max_settling": 4.0, **settings}),
        max_pressure=1.3e5,
        start=np.zeros(9),
        period=PERIOD,
        seed=0,
        samples=samples,
    )
    for _ in range(200_000):
        if running.done:
            return running
        robot.step(running.update(robot.measure()))
    raise AssertionError("identification did not end")


@pytest.mark.parametrize("times", [(0.04, 0.2, 0.4), (0.12, 0.5, 0.3)])
def test_dead_time_and_lags_of_a_known_robot(times: tuple[float, float, float]) -> None:
    dynamics = fit_identified_model(identified(Robot(*times)), period=PERIOD).dynamics
    assert dynamics.dead_time == pytest.approx(times[0], abs=0.01)
    assert dynamics.fill_lag == pytest.approx(times[1], rel=0.1)
    assert dynamics.vent_lag == pytest.approx(times[2], rel=0.1)
    assert dynamics.response_lag == 0.0


def test_creep_is_told_apart_from_what_holds_in_the_end() -> None:
    """Samples were taken 4 s after each way, when two fifths of the creep was yet to come."""
    model = fit_identified_model(identified(Robot(0.04, 0.2, 0.3)), period=PERIOD)
    own = np.diagonal(model.slopes(np.full(9, 0.22)))
    np.testing.assert_allclose(own, STIFFNESS, rtol=0.05)
    assert model.dynamics.memory[:3].sum(axis=0) == pytest.approx(CREEPING, rel=0.3)
    assert model.samples == 30


def test_without_steps_no_lag_is_made_up_for() -> None:
    dynamics = fit_identified_model(identified(Robot(0.1, 0.3, 0.3), steps=0), period=0.02).dynamics
    cautious = BellowsDynamics()
    assert (dynamics.fill_lag, dynamics.vent_lag) == (cautious.fill_lag, cautious.vent_lag)
    assert dynamics.response_lag == cautious.response_lag
    assert dynamics.memory.any()


def test_samples_that_make_no_model_are_refused() -> None:
    running = Identification(
        IdentificationSettings(),
        max_pressure=1.3e5,
        start=np.zeros(9),
        period=PERIOD,
        seed=0,
        samples=20,
    )
    with pytest.raises(EquilibriumModelError, match="at least 20 are needed"):
        fit_identified_model(running, period=PERIOD)
