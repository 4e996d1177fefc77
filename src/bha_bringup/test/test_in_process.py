"""Plant, controller and learner together, on the real plant, for as short as it makes sense."""

import numpy as np
import pytest

from bha_bringup.in_process import InProcessRobot
from bha_goal_babbling.learner import Learner
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.task import find_task
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from bha_pressure_ctrl.identification import IdentificationSettings
from bha_pressure_ctrl.pressure_control import PressureControl, PressureControlSettings

TASK = find_task("2d")
QUICK = IdentificationSettings(samples=20, max_settling=2.0, pressure_rate=1e5)
LEARNING = LearnerSettings(settling_time=5.0, reach_timeout=4.0)


def robot(seed: int = 0, model: EquilibriumModel | None = None) -> InProcessRobot:
    return InProcessRobot(
        TASK,
        seed=seed,
        learner_settings=LEARNING,
        control_settings=PressureControlSettings(seed=seed, identification=QUICK),
        model=model,
    )


@pytest.fixture(scope="module")
def model() -> EquilibriumModel:
    """Return an equilibrium model of robot 0, identified in a hurry."""
    return robot().identify()


def test_a_robot_without_a_model_stays_vented() -> None:
    fresh = robot()
    for _ in range(100):
        fresh.step()
    assert fresh.control.mode == PressureControl.NO_MODEL
    assert np.abs(fresh.plant.state.pressures).max() < 2e3  # the sensors' noise and offset


def test_time_begins_one_period_after_zero() -> None:
    """A stamp of 0 would be none."""
    fresh = robot()
    assert fresh.time == pytest.approx(0.02)
    fresh.step()
    assert fresh.tick == 1
    assert fresh.time == pytest.approx(0.04)


def test_the_model_holds_the_lengths_it_was_fitted_for(model: EquilibriumModel) -> None:
    held = robot(model=model)
    command = np.full(9, 0.2)
    errors = []
    for _ in range(1500):  # 30 s
        held.control.command(held.time, command)
        pressures = held.control.update(held.time, held.plant.state.lengths)
        held.plant.step(pressures)
        held.tick += 1
        errors.append(np.abs(held.plant.state.lengths - command).mean())
    assert np.mean(errors[-100:]) < 0.003


def test_babbles_and_reaches(model: EquilibriumModel) -> None:
    """Two minutes teach little, but every part has to do its work for that."""
    learning = robot(model=model)
    learning.babble(120.0)
    babbler = learning.learner.babbler
    assert babbler is not None
    assert babbler.samples == 2 * 120 - 11
    assert learning.learner.exploration_time == 120.0
    assert learning.learner.mode == Learner.HOLDING
    assert learning.control.mode == PressureControl.CONTROL
    home = learning.reach(np.array([*babbler.home_outcome, 0.75]))
    assert home.tip is not None
    assert home.error < 0.1
    assert home.duration <= 4.0


def test_the_same_seed_gives_the_same_bits(model: EquilibriumModel) -> None:
    """Whatever else ran in the process."""

    def samples(seed: int) -> np.ndarray:
        seen: list[np.ndarray] = []
        learning = robot(seed, model)
        learning.learner.on_sample = lambda lengths, outcome: seen.append(
            np.concatenate([lengths, outcome])
        )
        learning.babble(15.0)
        return np.array(seen)

    first = samples(0)
    assert first.shape == (19, 11)
    np.testing.assert_array_equal(samples(0), first)
    assert not np.array_equal(samples(1), first)


def test_babbling_without_a_model_ends_with_the_reason() -> None:
    with pytest.raises(RuntimeError, match="does the pressure controller have a model"):
        robot().babble(30.0)


def test_running_until_something_holds() -> None:
    fresh = robot()
    assert fresh.run_until(lambda: fresh.tick == 7, limit=1.0)
    assert fresh.tick == 7
    assert not fresh.run_until(lambda: False, limit=0.2)
    assert fresh.tick == 17
