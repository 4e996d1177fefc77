"""How exact the whole chain is on the real plant after a little time, in one process.

The bounds are about twice what is measured: they are for what breaks, the tables of
docs/results.md for how good it is.
"""

from statistics import mean, median

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.trunk.bha_runs import errors, held_out
from benchmarks.trunk.length_control_methods import LEARNED, controller
from benchmarks.trunk.length_responses import is_stable, new_plant, reachable, steps
from bha_bringup.in_process import InProcessRobot
from bha_goal_babbling.task import find_task
from bha_sim.disturbances import Disturbances

Array = NDArray[np.float64]

MINUTES = 10.0
TRACKER_NOISE = 1.5e-3  # [m]
TASK = find_task("2d")
GOALS = held_out(TASK, 0, 12)


@pytest.fixture(scope="module")
def robot() -> InProcessRobot:
    """Return robot 0 after ten minutes of exploration; tests leave it as it is."""
    robot = InProcessRobot(TASK, tip_noise=TRACKER_NOISE)
    robot.identify()
    robot.babble(60.0 * MINUTES)
    return robot


def test_the_controller_comes_to_lengths_quickly_without_going_beyond(
    robot: InProcessRobot,
) -> None:
    model, plant = robot.control.model, new_plant(0)
    assert model is not None
    goals = reachable(plant, 7, np.random.default_rng(0))
    told = steps(plant, controller(LEARNED, model), goals)
    assert median(told["rms within"]) < 1.0  # [s] to 2 mm
    assert mean(told["mean overshoot"]) < 2.0  # [mm]
    assert is_stable(plant, lambda: controller(LEARNED, model, 2.0), goals[:3])


def test_what_was_learned_brings_the_tip_to_goals(robot: InProcessRobot) -> None:
    assert errors(robot, GOALS).mean() < 0.012


def test_feedback_takes_away_what_is_left(robot: InProcessRobot) -> None:
    ends = []
    for goal in GOALS[:6]:
        movement = robot.reach_with_feedback(goal)
        tip = robot.plant.state.tip
        ends.append((movement.arrived, np.linalg.norm(TASK.outcome(tip) - TASK.outcome(goal))))
    arrived, left = np.array(ends).T
    assert arrived.sum() >= 4
    assert left.mean() < 0.004


def test_other_bellows_make_up_for_a_stuck_valve(robot: InProcessRobot) -> None:
    """Before anything new is learned; what was learned would miss by decimetres."""
    robot.plant.disturb(Disturbances(stuck_valves={"bellows_1_2": True}))
    found = errors(robot, GOALS).mean()
    robot.plant.disturb(Disturbances())
    assert found < 0.03
