"""Nodes that are killed and come back; nodes that are asked to end."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest
from bha_interfaces.action import Babble, ReachGoal
from bha_interfaces.msg import LearningStatus

from bha_common.ros_messages import nanoseconds
from bha_goal_babbling.checkpoint import load_checkpoint
from running_graph import GOAL, ROBOT, RunningGraph, StartGraph, goal

pytestmark = pytest.mark.graph

OTHER_GOAL = np.array([-0.10, 0.12, 0.78])

SHORT_WAITS = {
    "simulator": {"lockstep_timeout": 2.0},
    "pressure_ctrl": {"lockstep_timeout": 1.0},
    "learner": {"checkpoint_period": 10.0},
}


def distance_aside(tip: np.ndarray, goal: np.ndarray) -> float:
    return float(np.linalg.norm(tip[:2] - goal[:2]))


def hold_goal(graph: RunningGraph, goal: np.ndarray) -> None:
    """Set a goal and wait until the tip is about there."""
    graph.client.set_goal(goal)
    graph.wait(lambda: distance_aside(graph.tip(), goal) < 0.05, "the tip at the goal")


def wait_until_vented(graph: RunningGraph) -> None:
    graph.wait(lambda: graph.pressures().max() < 500.0, "vented bellows")


def test_a_killed_learner_goes_on_from_its_last_checkpoint(start_graph: StartGraph) -> None:
    graph = start_graph(parameters=SHORT_WAITS)
    graph.wait_robot(1.0)
    checkpoint_file = graph.folder / "models" / "inverse_model.npz"
    assert graph.client.status is not None
    begin = graph.client.status.exploration_time
    graph.begin(Babble, "learner/babble", Babble.Goal(duration=3600.0))
    graph.wait(lambda: graph.client.status.exploration_time >= begin + 45.0, "45 s of exploration")
    graph.end("learner", signal.SIGKILL)
    known = graph.client.status

    # Controller and robot come to the safe state.
    wait_until_vented(graph)
    assert "no valid length_command" in graph.fresh("pressure_ctrl")["summary"]
    assert graph.fresh("pressure_ctrl")["commander"] == "silent"

    # What is on the disk is whole, and not older than a checkpoint period.
    stored = load_checkpoint(checkpoint_file, robot=ROBOT, task="2d")
    assert stored.exploration_time > known.exploration_time - 10.0 - 0.5
    assert list(checkpoint_file.parent.glob(".*")) == []

    graph.client.status = None
    graph.restart("learner")
    graph.wait(lambda: graph.client.status is not None, "a learning_status")
    status = graph.client.status
    assert status.exploration_time == stored.exploration_time
    assert (status.movements, status.samples) == (stored.babbler.movements, stored.babbler.samples)
    assert status.mode == LearningStatus.IDLE
    graph.wait(lambda: graph.values("pressure_ctrl")["mode"] == "control", "control")
    # It does not go on by itself, but when it is asked to.
    handle = graph.begin(Babble, "learner/babble", Babble.Goal(duration=20.0))
    result = graph.result(handle)
    assert result.success, result.message
    assert result.status.exploration_time == stored.exploration_time + 20.0
    assert result.status.samples > stored.babbler.samples
    hold_goal(graph, GOAL)


@pytest.mark.parametrize("real_time_factor", [0.0, 2.0], ids=["lockstep", "paced"])
def test_a_killed_controller_lets_the_robot_vent_and_controls_again_with_its_model(
    start_graph: StartGraph, real_time_factor: float
) -> None:
    graph = start_graph(parameters=SHORT_WAITS, real_time_factor=real_time_factor)
    graph.wait_robot(1.0)
    hold_goal(graph, GOAL)
    graph.end("pressure_ctrl", signal.SIGKILL)
    wait_until_vented(graph)
    assert "no valid pressure_command" in graph.fresh("simulator")["summary"]
    if real_time_factor == 0.0:
        assert graph.values("simulator")["lockstep"] == "False"
        assert int(graph.values("simulator")["lockstep timeouts"]) >= 1
    # The learner goes on: it holds its command.
    assert graph.fresh("learner")["mode"] in (LearningStatus.REACHING, LearningStatus.HOLDING)

    graph.restart("pressure_ctrl")
    graph.wait(lambda: graph.values("pressure_ctrl")["mode"] == "control", "control")
    graph.wait(lambda: distance_aside(graph.tip(), GOAL) < 0.05, "the tip back at the goal")
    hold_goal(graph, OTHER_GOAL)
    graph.wait(lambda: graph.values("simulator")["state"] == "running", "the robot running")
    lockstep = str(real_time_factor == 0.0)
    graph.wait(lambda: graph.values("simulator")["lockstep"] == lockstep, "lockstep again")


@pytest.mark.parametrize("real_time_factor", [0.0, 2.0], ids=["lockstep", "paced"])
def test_a_killed_simulator_comes_back_with_a_new_time(
    start_graph: StartGraph, real_time_factor: float
) -> None:
    graph = start_graph(parameters=SHORT_WAITS, real_time_factor=real_time_factor)
    graph.wait_robot(1.0)
    hold_goal(graph, GOAL)
    handle = graph.begin(Babble, "learner/babble", Babble.Goal(duration=3600.0))
    before = graph.client.status.samples
    graph.wait(lambda: graph.client.status.samples > before + 5, "some samples")
    samples, end = graph.client.status.samples, graph.now()
    told = graph.listen("pressures").messages
    told.clear()
    graph.end("simulator", signal.SIGKILL)
    graph.restart("simulator")
    # In lockstep it may be beyond the old time again already.
    graph.wait(
        lambda: any(nanoseconds(message.header.stamp) < end for message in told),
        "the robot's new time",
    )

    # Babbling ends, since the robot is another one; what was learned is kept.
    result = graph.result(handle)
    assert not result.success
    assert "a new robot" in result.message
    assert result.status.samples >= samples
    for name in ("learner", "pressure_ctrl"):
        graph.wait(
            lambda name=name: "the robot's time has begun anew" in graph.log(name, 1000),
            f"{name} telling of it",
        )
    # Feedback writes of the first tip of the new time, unless that is beyond the old one again.
    graph.wait(
        lambda: "is not newer" in graph.log("cartesian_feedback", 1000) or graph.now() > end,
        "feedback seeing the new robot",
    )
    # Nothing is brought back: the robot stays about where it is until there is a new goal.
    graph.wait(lambda: graph.client.status.mode == LearningStatus.IDLE, "idle")
    graph.wait_robot(3.0)
    assert graph.pressures().max() < 2e4
    hold_goal(graph, GOAL)
    hold_goal(graph, OTHER_GOAL)
    assert graph.client.reach(GOAL, feedback=True, timeout=60.0).error < 0.02
    lockstep = str(real_time_factor == 0.0)
    graph.wait(lambda: graph.values("simulator")["lockstep"] == lockstep, "lockstep again")


def test_a_killed_feedback_leaves_the_learner_in_charge(start_graph: StartGraph) -> None:
    graph = start_graph(parameters=SHORT_WAITS)
    graph.wait(lambda: graph.values("cartesian_feedback")["summary"] == "idle", "feedback ready")
    graph.client.set_goal(GOAL, feedback=True)
    graph.wait(lambda: graph.client.status.mode == LearningStatus.HOLDING, "targets followed")
    graph.wait(lambda: distance_aside(graph.tip(), GOAL) < 0.05, "the tip at the goal")
    graph.end("cartesian_feedback", signal.SIGKILL)
    graph.wait_robot(3.0)
    assert graph.fresh("learner")["mode"] == LearningStatus.HOLDING
    assert distance_aside(graph.tip(), GOAL) < 0.05
    hold_goal(graph, OTHER_GOAL)
    graph.restart("cartesian_feedback")
    graph.wait(lambda: graph.values("cartesian_feedback")["summary"] == "idle", "feedback ready")
    graph.client.set_goal(GOAL, feedback=True)
    graph.wait(lambda: distance_aside(graph.tip(), GOAL) < 0.05, "the tip at the goal")


def test_feedback_does_not_go_on_with_a_learner_that_knows_nothing_of_its_goal(
    start_graph: StartGraph,
) -> None:
    """A learner that was started again counts its goals from 0."""
    graph = start_graph(parameters=SHORT_WAITS)
    graph.wait(lambda: graph.values("cartesian_feedback")["summary"] == "idle", "feedback ready")
    where = ReachGoal.Goal(goal=goal(*GOAL), tolerance=1e-6, timeout=3600.0)
    handle = graph.begin_reach("cartesian_feedback", where)
    graph.wait_robot(3.0)
    graph.end("learner", signal.SIGKILL)
    graph.restart("learner")
    assert "ended by another goal, the learner" in graph.result(handle).message
    hold_goal(graph, OTHER_GOAL)


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
def test_every_node_ends_when_it_is_asked_to(
    start_graph: StartGraph, how: signal.Signals, trained: Path
) -> None:
    """Within 3 s and with code 0, in the middle of its work; the learner keeps what it learned."""
    graph = start_graph(parameters={"learner": {"checkpoint_period": 1e4}})
    graph.wait_robot(1.0)
    graph.begin(Babble, "learner/babble", Babble.Goal(duration=3600.0))
    graph.wait(lambda: graph.client.status is not None, "a learning_status")
    before = graph.client.status.samples
    graph.wait(lambda: graph.client.status.samples > before + 5, "some samples")
    samples = graph.client.status.samples
    for name in ("learner", "cartesian_feedback", "pressure_ctrl", "simulator"):
        code, took = graph.end(name, how)
        assert code == 0, graph.log(name)
        assert took < 3.0, f"{name} took {took:.1f} s"
        assert "Traceback" not in graph.log(name, 1000)
    stored = load_checkpoint(graph.folder / "models" / "inverse_model.npz", robot=ROBOT)
    assert stored.babbler.samples >= samples
