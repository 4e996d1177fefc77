"""Lockstep: the samples of the graph are those of the composition in one process, bit for bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bha_interfaces.action import Babble

from bha_bringup.in_process import InProcessRobot
from bha_common.ros_messages import lengths_from, nanoseconds
from bha_goal_babbling.checkpoint import Checkpoint, load_checkpoint
from bha_goal_babbling.task import find_task
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from running_graph import ROBOT, RunningGraph, StartGraph

pytestmark = pytest.mark.graph

DURATION = 125.0
"""Robot time to explore [s]: 15 s of homing, then a sample every 0.5 s."""

WAITS_FOR_A_BUSY_MACHINE = {
    "simulator": {"lockstep_timeout": 60.0},
    "pressure_ctrl": {"lockstep_timeout": 30.0},
}
"""The question is what is computed, not how fast: lockstep is not to end when a node is late."""


def explore_over_ros(graph: RunningGraph) -> tuple[Checkpoint, list[tuple[int, np.ndarray]]]:
    """Babble from the first state on; what is learned, and each (stamp [ns], lengths) commanded."""
    # A second round of diagnostics: the nodes have had time to find one another.
    for name in graph.names:
        graph.fresh(name)
    commands = graph.listen("length_command")
    graph.publisher("target")  # found by the learner, and so its publishers are by the client
    handle = graph.begin(Babble, "learner/babble", Babble.Goal(duration=DURATION))
    assert handle.accepted
    graph.client.pause(False)
    result = graph.result(handle, timeout=240.0)
    assert result.success, result.message
    path = graph.folder / "explored.npz"
    graph.client.save("learner", str(path))
    return load_checkpoint(path, robot=ROBOT, task="2d"), [
        (nanoseconds(message.header.stamp), lengths_from(message)) for message in commands.messages
    ]


def explore_in_process(
    model_file: Path,
) -> tuple[Checkpoint, list[tuple[int, np.ndarray]], int]:
    """Do the same without ROS; also the number of samples."""
    model = EquilibriumModel.load(model_file, ROBOT)
    robot = InProcessRobot(find_task("2d"), seed=0, model=model)
    samples = []
    robot.learner.on_sample = lambda lengths, outcome: samples.append((lengths, outcome))
    commands = []
    update = robot.learner.update

    def noting(time: int) -> np.ndarray | None:
        command = update(time)
        if command is not None:
            commands.append((time, command.copy()))
        return command

    robot.learner.update = noting  # type: ignore[method-assign]
    robot.babble(DURATION)
    assert robot.learner.babbler is not None
    checkpoint = Checkpoint(robot.learner.babbler, "2d", robot.learner.exploration_time)
    return checkpoint, commands, len(samples)


def test_the_graph_learns_what_one_process_learns_bit_for_bit(
    start_graph: StartGraph, trained: Path
) -> None:
    graph = start_graph(
        models=("equilibrium_model",), start_paused=True, parameters=WAITS_FOR_A_BUSY_MACHINE
    )
    over_ros, commands_over_ros = explore_over_ros(graph)
    in_process, commands_in_process, samples = explore_in_process(trained / "equilibrium_model.npz")
    assert graph.fresh("simulator")["lockstep timeouts"] == "0"
    assert samples >= 200
    assert over_ros.babbler.samples == in_process.babbler.samples == samples
    assert over_ros.exploration_time == in_process.exploration_time == DURATION

    # Every command depends on every sample before it: the first that differs tells where.
    assert len(commands_over_ros) >= len(commands_in_process)
    for (stamp, lengths), (time, wanted) in zip(
        commands_over_ros, commands_in_process, strict=False
    ):
        assert stamp == time
        assert np.array_equal(lengths, wanted), f"commands differ at {time * 1e-9:.2f} s"

    state, wanted_state = over_ros.babbler.state(), in_process.babbler.state()
    assert state.arrays.keys() == wanted_state.arrays.keys()
    for name, array in state.arrays.items():
        assert array.tobytes() == wanted_state.arrays[name].tobytes(), name
    assert state.settings == wanted_state.settings
