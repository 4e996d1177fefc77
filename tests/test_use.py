"""What goals of a user teach, over the graph: as much as the learner is told to take."""

from __future__ import annotations

import numpy as np
import pytest

from bha_goal_babbling.checkpoint import load_checkpoint
from running_graph import ROBOT, StartGraph

pytestmark = pytest.mark.graph

GOALS = (np.array([0.2, 0.1, 0.74]), np.array([-0.15, 0.2, 0.74]))


@pytest.mark.parametrize("lesson", ["nothing", "offsets", "everything"])
def test_goals_of_a_user_teach_and_what_they_teach_is_kept(
    start_graph: StartGraph, lesson: str
) -> None:
    graph = start_graph(parameters={"learner": {"learn_in_use": lesson}})
    for goal in GOALS:
        graph.client.reach(goal, timeout=60.0)
    examples = int(graph.fresh("learner")["examples in use"])
    if lesson != "nothing":  # some on the way to each goal; how many depends on when its tips come
        assert examples >= 2 * len(GOALS)
    else:
        assert examples == 0

    path = graph.folder / "used.npz"
    graph.client.save("learner", str(path))
    used = load_checkpoint(path, robot=ROBOT, task="2d").babbler
    before = load_checkpoint(
        graph.folder / "models" / "inverse_model.npz", robot=ROBOT, task="2d"
    ).babbler
    maps, offsets = (
        [babbler.state().arrays[name] for babbler in (before, used)]
        for name in ("learned_maps_parameters", "body_offsets_values")
    )
    assert np.array_equal(*maps) == (lesson != "everything")
    assert np.array_equal(*offsets) == (lesson == "nothing")
    assert used.samples == before.samples
