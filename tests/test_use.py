"""Learning goes on while the robot is used: over the graph, when the learner is told so."""

from __future__ import annotations

import numpy as np
import pytest

from bha_goal_babbling.checkpoint import load_checkpoint
from running_graph import ROBOT, StartGraph

pytestmark = pytest.mark.graph

GOALS = (np.array([0.2, 0.1, 0.74]), np.array([-0.15, 0.2, 0.74]))


@pytest.mark.parametrize("learns", [True, False])
def test_goals_of_a_user_are_learned_and_kept(start_graph: StartGraph, learns: bool) -> None:
    graph = start_graph(parameters={"learner": {"learn_in_use": learns}})
    for goal in GOALS:
        graph.client.reach(goal, timeout=60.0)
    examples = int(graph.fresh("learner")["examples in use"])
    if learns:  # some on the way to each goal; how many depends on when its tips come
        assert examples >= 2 * len(GOALS)
    else:
        assert examples == 0

    path = graph.folder / "used.npz"
    graph.client.save("learner", str(path))
    used = load_checkpoint(path, robot=ROBOT, task="2d").babbler
    before = load_checkpoint(
        graph.folder / "models" / "inverse_model.npz", robot=ROBOT, task="2d"
    ).babbler
    goals = np.array([goal[:2] for goal in GOALS])
    assert np.array_equal(used.inverse(goals), before.inverse(goals)) != learns
    assert used.samples == before.samples
