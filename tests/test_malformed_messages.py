"""Bad input to running nodes: dropped whole, counted, named, and of no effect."""

from __future__ import annotations

import numpy as np
import pytest
from bha_interfaces.msg import LearningStatus

from malformed_messages import TOPICS
from running_graph import GOAL, RunningGraph, StartGraph

pytestmark = pytest.mark.graph


class TestMalformedMessages:
    """On every input of every node of a robot that holds a posture, in real time."""

    @pytest.fixture(scope="class")
    @staticmethod
    def graph(start_shared_graph: StartGraph) -> RunningGraph:
        graph = start_shared_graph(real_time_factor=2.0)
        graph.wait_robot(1.0)
        graph.client.set_goal(GOAL)
        graph.wait_robot(10.0)
        return graph

    @pytest.mark.parametrize("topic", TOPICS)
    def test_they_are_dropped_whole_counted_and_named(
        self, graph: RunningGraph, topic: str
    ) -> None:
        make, faults, nodes = TOPICS[topic]
        publisher = graph.publisher(topic)
        commands = graph.listen("length_command")
        tip = graph.tip()
        counts = {node: int(graph.fresh(node)[f"{topic} dropped"]) for node in nodes}
        for fault, (spoil, reason) in faults.items():
            for _ in range(5):
                now = graph.now()
                message = make(now)
                spoil(message, now)
                publisher.publish(message)
            for node in nodes:
                counts[node] += 5
                graph.wait(
                    lambda node=node: graph.dropped(node, topic) >= counts[node],
                    f"{node} to drop five messages on {topic} with {fault}",
                )
                assert reason in graph.values(node)[f"{topic} last reason"], fault
                assert graph.dropped(node, topic) == counts[node], fault
                assert f"dropped a message on {topic}" in graph.log(node, lines=10)
        graph.wait_robot(2.0)
        assert np.linalg.norm(graph.tip() - tip) < 0.02  # it creeps; those would move it 0.3 m
        # The valid stream goes on, and nobody took the robot for another one.
        count = len(commands.messages)
        graph.wait(lambda: len(commands.messages) > count + 2, "commands of the learner")
        assert graph.fresh("simulator")["state"] == "running"
        assert graph.fresh("pressure_ctrl")["mode"] == "control"
        assert graph.fresh("learner")["mode"] == LearningStatus.HOLDING
        assert "begun anew" not in graph.log("learner", 1000) + graph.log("pressure_ctrl", 1000)
