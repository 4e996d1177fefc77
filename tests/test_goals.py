"""Goals and tasks that nodes must refuse, with the reason, by service and action alike."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from bha_interfaces.action import Babble, Identify, ReachGoal
from bha_interfaces.msg import LearningStatus
from bha_interfaces.srv import SetGoal
from geometry_msgs.msg import PointStamped

from bha_bringup.robot_connection import RobotError
from bha_common.ros_messages import point_message
from running_graph import GOAL, NODES_OF_GOALS, RunningGraph, StartGraph, goal

pytestmark = pytest.mark.graph

BAD_GOALS = {
    "NaN": (goal(math.nan, 0.0, 0.8), "not finite"),
    "inf": (goal(0.0, math.inf, 0.8), "not finite"),
    "wrong frame": (goal(0.0, 0.0, 0.8, "world"), "frame_id is 'world'"),
    "far outside": (goal(3.0, 0.0, 0.8), "the goal is refused"),
}


def why_refused(graph: RunningGraph, node: str, where: PointStamped, **limits: float) -> list[str]:
    """Offer a goal to the service and to the action of a node; what both say."""
    answer = graph.client.call(SetGoal, f"{node}/set_goal", SetGoal.Request(goal=where))
    assert not answer.accepted
    handle = graph.begin(ReachGoal, f"{node}/reach_goal", ReachGoal.Goal(goal=where, **limits))
    result = graph.result(handle)
    assert not result.success
    return [answer.message, result.message]


class TestGoals:
    """Goals are refused with the reason, by the service and the action of both nodes."""

    @pytest.fixture(scope="class")
    @staticmethod
    def shared(start_shared_graph: StartGraph) -> RunningGraph:
        graph = start_shared_graph()
        graph.wait_robot(1.0)
        return graph

    @pytest.fixture
    def graph(self, shared: RunningGraph) -> Iterator[RunningGraph]:
        commands = shared.listen("length_command")
        shared.wait(lambda: bool(commands.messages), "a command")
        yield shared
        # Nothing was accepted on the way.
        assert shared.client.status.mode in (LearningStatus.IDLE, LearningStatus.HOLDING)

    @pytest.mark.parametrize("node", NODES_OF_GOALS)
    @pytest.mark.parametrize("fault", BAD_GOALS)
    def test_a_bad_goal(self, graph: RunningGraph, node: str, fault: str) -> None:
        before = graph.listen("length_command").last.position
        where, reason = BAD_GOALS[fault]
        for message in why_refused(graph, node, where):
            assert reason in message
        graph.wait_robot(1.0)
        assert graph.listen("length_command").last.position == before

    @pytest.mark.parametrize("node", NODES_OF_GOALS)
    @pytest.mark.parametrize("limits", [{"tolerance": -1.0}, {"timeout": math.nan}])
    def test_bad_limits(self, graph: RunningGraph, node: str, limits: dict[str, float]) -> None:
        handle = graph.begin(
            ReachGoal, f"{node}/reach_goal", ReachGoal.Goal(goal=goal(*GOAL), **limits)
        )
        (name,) = limits
        assert f"{name} must be 0 or above" in graph.result(handle).message

    @pytest.mark.parametrize("duration", [0.0, -1.0, math.nan, math.inf])
    def test_a_bad_duration_of_babbling(self, graph: RunningGraph, duration: float) -> None:
        handle = graph.begin(Babble, "learner/babble", Babble.Goal(duration=duration))
        assert not handle.accepted
        assert f"duration must be above 0 s, got {duration}" in graph.log("learner")

    def test_too_few_samples_to_identify(self, graph: RunningGraph) -> None:
        handle = graph.begin(Identify, "pressure_ctrl/identify", Identify.Goal(samples=3))
        assert not handle.accepted
        assert "at least 20" in graph.log("pressure_ctrl")
        with pytest.raises(RobotError, match="refused: the log of pressure_ctrl says why"):
            graph.client.identify(3)

    def test_while_it_babbles(self, graph: RunningGraph) -> None:
        handle = graph.begin(Babble, "learner/babble", Babble.Goal(duration=3600.0))
        graph.wait(lambda: graph.client.status.mode == LearningStatus.BABBLING, "babbling")
        for node in NODES_OF_GOALS:
            for message in why_refused(graph, node, goal(*GOAL)):
                assert "it babbles and accepts nothing else" in message
        second = graph.begin(Babble, "learner/babble", Babble.Goal(duration=10.0))
        assert not second.accepted
        # A target that somebody publishes is refused as well, and counted.
        before = int(graph.fresh("learner")["target dropped"])
        targets = graph.publisher("target")
        graph.repeat(
            lambda: targets.publish(point_message(graph.now(), GOAL)),
            lambda: graph.dropped("learner", "target") > before,
            "a target to be refused",
        )
        assert graph.client.status.mode == LearningStatus.BABBLING
        handle.cancel_goal_async()
        assert "kept" in graph.result(handle).message
        graph.wait(lambda: graph.client.status.mode == LearningStatus.HOLDING, "holding")

    def test_during_an_emergency_stop(self, graph: RunningGraph) -> None:
        graph.client.emergency_stop()
        try:
            graph.wait(lambda: graph.client.status.mode == LearningStatus.STOPPED, "stopped")
            for node in NODES_OF_GOALS:
                for message in why_refused(graph, node, goal(*GOAL)):
                    assert "the emergency stop is active" in message
            for kind, name, request in (
                (Babble, "learner/babble", Babble.Goal(duration=10.0)),
                (Identify, "pressure_ctrl/identify", Identify.Goal()),
            ):
                assert not graph.begin(kind, name, request).accepted
        finally:
            graph.client.emergency_stop_reset()
        graph.wait(lambda: graph.client.status.mode == LearningStatus.IDLE, "idle")
