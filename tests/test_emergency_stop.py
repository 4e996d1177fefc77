"""The emergency stop of the whole graph: it vents, it is latched, it ends what is under way."""

from __future__ import annotations

import numpy as np
import pytest
from bha_interfaces.action import Babble, Identify, ReachGoal
from bha_interfaces.msg import LearningStatus
from std_srvs.srv import Trigger

from running_graph import GOAL, NODES_OF_GOALS, RunningGraph, StartGraph, goal

pytestmark = pytest.mark.graph


class TestEmergencyStop:
    @pytest.fixture(scope="class")
    @staticmethod
    def graph(start_shared_graph: StartGraph) -> RunningGraph:
        graph = start_shared_graph()
        graph.wait_robot(1.0)
        return graph

    def _under_pressure(self, graph: RunningGraph, feedback: bool) -> None:
        graph.client.set_goal(GOAL, feedback=feedback)
        graph.wait(lambda: graph.pressures().max() > 4e4, "pressures")

    @pytest.mark.parametrize("feedback", [False, True])
    def test_it_vents_and_its_reset_does_not_bring_the_old_command_back(
        self, graph: RunningGraph, feedback: bool
    ) -> None:
        self._under_pressure(graph, feedback)
        graph.client.emergency_stop()
        for node in ("simulator", "pressure_ctrl"):
            graph.wait(
                lambda node=node: "emergency stop" in graph.values(node)["summary"],
                f"{node} in its safe state",
            )
        self._vented_and_reset(graph)
        self._under_pressure(graph, feedback)

    @pytest.mark.parametrize("paused", [False, True])
    def test_a_reset_that_follows_at_once_does_not_either(
        self, graph: RunningGraph, paused: bool
    ) -> None:
        """Also where no node has computed anything between the stop and its reset."""
        self._under_pressure(graph, feedback=True)
        graph.wait(lambda: graph.client.status.mode == LearningStatus.HOLDING, "targets followed")
        clients = [
            graph.client.node.create_client(Trigger, name)
            for name in ("emergency_stop", "emergency_stop_reset")
        ]
        graph.wait(lambda: all(client.service_is_ready() for client in clients), "the services")
        graph.client.pause(paused)
        commands = graph.listen("length_command")
        answers = [client.call_async(Trigger.Request()) for client in clients]
        graph.wait(lambda: all(answer.done() for answer in answers), "both answers")
        graph.fresh("learner")  # it has taken both, and so has feedback
        graph.fresh("cartesian_feedback")
        if paused:
            before = commands.last.position
            graph.client.pause(False)
            # The learner holds the robot where the stop has found it: no way back to the goal.
            count = len(commands.messages)
            graph.wait(lambda: len(commands.messages) > count, "a command")
            assert np.abs(np.array(commands.last.position) - before).min() > 0.0
        graph.wait(lambda: graph.client.status.mode == LearningStatus.IDLE, "idle")
        held = commands.last.position
        graph.wait_robot(5.0)
        assert commands.last.position == held
        assert graph.fresh("cartesian_feedback")["summary"] == "idle"
        assert graph.fresh("pressure_ctrl")["mode"] == "control"

    def test_it_ends_a_movement_and_says_so(self, graph: RunningGraph) -> None:
        for node in NODES_OF_GOALS:
            handle = graph.begin_reach(
                node, ReachGoal.Goal(goal=goal(*GOAL), tolerance=1e-6, timeout=600.0)
            )
            graph.wait_robot(0.5)
            graph.client.emergency_stop()
            assert "emergency stop" in graph.result(handle).message
            graph.client.emergency_stop_reset()
            graph.wait(lambda: graph.client.status.mode == LearningStatus.IDLE, "idle")

    def test_it_ends_identification_and_the_model_in_use_stays(self, graph: RunningGraph) -> None:
        handle = graph.begin(Identify, "pressure_ctrl/identify", Identify.Goal(samples=50))
        graph.wait_robot(2.0)
        graph.client.emergency_stop()
        result = graph.result(handle)
        assert not result.success
        graph.client.emergency_stop_reset()
        assert graph.fresh("pressure_ctrl")["model"] == "24 samples"

    def test_it_ends_babbling_and_what_was_learned_is_kept(self, graph: RunningGraph) -> None:
        handle = graph.begin(Babble, "learner/babble", Babble.Goal(duration=3600.0))
        before = graph.client.status.samples
        graph.wait(lambda: graph.client.status.samples >= before + 5, "five samples")
        graph.client.emergency_stop()
        result = graph.result(handle)
        assert not result.success
        assert "emergency stop" in result.message
        assert result.status.samples >= before + 5
        self._vented_and_reset(graph)
        assert graph.client.status.samples == result.status.samples
        graph.client.set_goal(GOAL)

    def _vented_and_reset(self, graph: RunningGraph) -> None:
        """Wait until the vented robot is at rest and reset the stop: it stays there."""
        graph.wait(lambda: graph.pressures().max() < 500.0, "vented bellows")
        graph.wait_robot(20.0)  # it takes that long to sink; what is held before needs pressure
        pressures = graph.listen("pressures")
        commands, lengths = graph.listen("length_command"), graph.listen("lengths")
        graph.client.emergency_stop_reset()
        graph.wait(lambda: graph.client.status.mode == LearningStatus.IDLE, "idle")
        begin = len(pressures.messages)
        graph.wait_robot(8.0)
        # Holding the vented lengths takes no more pressure than the model is wrong by.
        assert max(max(message.pressure) for message in pressures.messages[begin:]) < 2e4
        assert np.abs(np.subtract(commands.last.position, lengths.last.position)).max() < 0.01
