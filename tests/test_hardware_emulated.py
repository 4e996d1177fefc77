"""The swap: the same graph with driver, Modbus and terminal in the simulator's place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bha_goal_babbling.checkpoint import load_checkpoint
from running_graph import PATIENCE, StartGraph

pytestmark = [pytest.mark.graph, pytest.mark.slow]


def test_a_model_of_the_simulator_is_loaded_used_and_improved(
    start_graph: StartGraph, trained: Path
) -> None:
    before = load_checkpoint(trained / "inverse_model.npz", robot=None)
    graph = start_graph(robot="hardware-emulated", real_time_factor=1.0)
    client = graph.client
    graph.wait(lambda: graph.values("driver").get("summary") == "running", "a running driver")

    goal = np.array([0.06, 0.05, 0.0])
    reached = client.reach(goal)
    assert reached.error < 0.05, "what was learned in the simulator holds behind the terminal"
    reached = client.reach(goal, feedback=True, timeout=30.0)
    assert reached.error < 0.01

    result = client.babble(20.0)
    assert result.success
    assert result.status.movements > before.babbler.movements
    assert result.status.exploration_time > before.exploration_time
    client.save("learner")
    after = load_checkpoint(graph.folder / "models" / "inverse_model.npz", robot="bha_sim_0")
    assert after.babbler.samples > before.babbler.samples
    graph.wait(lambda: graph.fresh("driver")["faults"] == "none", "no fault", PATIENCE)
