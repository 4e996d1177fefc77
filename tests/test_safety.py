"""The safety table against the running nodes: bad input, silence, ranges, emergency stop."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from bha_interfaces.action import Babble, Identify, ReachGoal
from bha_interfaces.msg import LearningStatus
from bha_interfaces.srv import SetGoal
from geometry_msgs.msg import Point, PointStamped
from std_srvs.srv import Trigger

from bha_common import bellows
from bha_common.ros_messages import (
    lengths_message,
    nanoseconds,
    point_message,
    pressures_message,
    stamp_message,
    tip_message,
)
from running_graph import RunningGraph, StartGraph

pytestmark = pytest.mark.graph

GOAL = np.array([0.10, 0.05, 0.78])
SECOND = 1_000_000_000

# --- messages that are to be dropped -----------------------------------------------------------


def _values(message: Any) -> Any:
    return message.pressure if hasattr(message, "pressure") else message.position


def _first(value: float) -> Callable[[Any, int], None]:
    def spoil(message: Any, _: int) -> None:
        _values(message)[0] = value

    return spoil


def _eight_values(message: Any, _: int) -> None:
    _values(message).pop()
    message.name = message.name[:-1]


def _ten_values(message: Any, _: int) -> None:
    _values(message).append(0.2)
    message.name = [*message.name, "bellows_4_1"]


def _no_names(message: Any, _: int) -> None:
    message.name = []


def _unknown_name(message: Any, _: int) -> None:
    message.name = [*message.name[:-1], "wrist_1"]


def _doubled_name(message: Any, _: int) -> None:
    message.name = [*message.name[:-1], message.name[0]]


def _stamped(age: float | None) -> Callable[[Any, int], None]:
    def spoil(message: Any, now: int) -> None:
        message.header.stamp = stamp_message(0 if age is None else now - round(age * SECOND))

    return spoil


def _frame(name: str) -> Callable[[Any, int], None]:
    def spoil(message: Any, _: int) -> None:
        message.header.frame_id = name

    return spoil


def _coordinate(value: float) -> Callable[[Any, int], None]:
    def spoil(message: Any, _: int) -> None:
        point = message.point if hasattr(message, "point") else message.pose.position
        point.y = value

    return spoil


OF_NINE = {
    "NaN": (_first(math.nan), "not finite for bellows_1_1"),
    "inf": (_first(-math.inf), "not finite for bellows_1_1"),
    "eight values": (_eight_values, "8 values; 9 are needed"),
    "ten values": (_ten_values, "10 values; 9 are needed"),
    "no names": (_no_names, "0 names"),
    "unknown name": (_unknown_name, "unknown ['wrist_1'], missing ['bellows_3_3']"),
    "doubled name": (_doubled_name, "unknown none, missing ['bellows_3_3']"),
}
OF_A_POINT = {
    "NaN": (_coordinate(math.nan), "not finite"),
    "inf": (_coordinate(math.inf), "not finite"),
    "wrong frame": (_frame("map"), "frame_id is 'map'; it must be 'bha_base'"),
    "no frame": (_frame(""), "frame_id is ''; it must be 'bha_base'"),
}
STAMPS = {
    "no stamp": (_stamped(None), "no stamp"),
    "too old": (_stamped(5.0), "s old; at most"),
    "future": (_stamped(-500.0), "s old; at most"),
}
STREAM_STAMPS = {
    "no stamp": (_stamped(None), "no stamp"),
    "too old": (_stamped(5.0), "not newer"),
    "future": (_stamped(-500.0), "leaps ahead"),
}
TIP_STAMPS = {
    "no stamp": (_stamped(None), "no stamp"),
    "too old": (_stamped(5.0), "stamp"),
    "future": (_stamped(-500.0), "stamp"),
}

BAD_LENGTHS = np.full(bellows.COUNT, 0.30)
BAD_PRESSURES = np.full(bellows.COUNT, bellows.MAX_PRESSURE)
BAD_POINT = np.array([0.3, 0.3, 0.6])

TOPICS: dict[str, tuple[Callable[[int], Any], dict[str, Any], tuple[str, ...]]] = {
    "pressure_command": (
        lambda now: pressures_message(now, BAD_PRESSURES),
        {**OF_NINE, **STAMPS},
        ("simulator",),
    ),
    "length_command": (
        lambda now: lengths_message(now, BAD_LENGTHS),
        {**OF_NINE, **STAMPS},
        ("pressure_ctrl",),
    ),
    "lengths": (
        lambda now: lengths_message(now, BAD_LENGTHS),
        {**OF_NINE, **STREAM_STAMPS, "millimetres": (_first(300.0), "is it in metres?")},
        ("pressure_ctrl", "learner"),
    ),
    "tip": (
        lambda now: tip_message(now, BAD_POINT, np.array([0.0, 0.0, 0.0, 1.0])),
        {**OF_A_POINT, **TIP_STAMPS, "millimetres": (_coordinate(300.0), "is it in metres,")},
        ("learner", "cartesian_feedback"),
    ),
    "target": (lambda now: point_message(now, BAD_POINT), {**OF_A_POINT, **STAMPS}, ("learner",)),
}
"""A message that would move the robot, what can be wrong with it, and who must drop it."""


def dropped(graph: RunningGraph, node: str, topic: str) -> int:
    return int(graph.values(node)[f"{topic} dropped"])


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
                    lambda node=node: dropped(graph, node, topic) >= counts[node],
                    f"{node} to drop five messages on {topic} with {fault}",
                )
                assert reason in graph.values(node)[f"{topic} last reason"], fault
                assert dropped(graph, node, topic) == counts[node], fault
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


# --- one node alone, driven by hand ------------------------------------------------------------


class Hand:
    """Answers every state of a simulator in lockstep, in the place of the pressure controller."""

    def __init__(self, graph: RunningGraph) -> None:
        self.graph = graph
        self.publisher = graph.publisher("pressure_command")
        self.lengths = graph.listen("lengths")
        self.measured = graph.listen("pressures")
        graph.client.pause(False)

    def drive(
        self, pressures: np.ndarray, ticks: int, after: Callable[[int], None] = lambda _: None
    ) -> None:
        """Command pressures (9,) [Pa] for some control periods, and something after each."""
        for _ in range(ticks):
            stamp = self.state()
            self.publisher.publish(pressures_message(stamp, pressures))
            after(stamp)
            self.graph.wait(lambda stamp=stamp: self.state() > stamp, "the next state")

    def state(self) -> int:
        """Stamp of the newest state [ns]."""
        self.graph.wait(lambda: bool(self.lengths.messages), "a state")
        return nanoseconds(self.lengths.last.header.stamp)

    def pressures(self) -> np.ndarray:
        """The newest measured pressures [Pa], shape (9,)."""
        return np.array(self.measured.last.pressure)

    def curve(self, since: int) -> tuple[np.ndarray, np.ndarray]:
        """Robot times (n,) [s] and measured pressures (n, 9) [Pa] after a stamp [ns]."""
        stamps = [nanoseconds(message.header.stamp) for message in self.measured.messages]
        kept = [
            (stamp * 1e-9, message.pressure)
            for stamp, message in zip(stamps, self.measured.messages, strict=True)
            if stamp > since
        ]
        return np.array([time for time, _ in kept]), np.array([values for _, values in kept])


SOME = np.linspace(3e4, 7e4, bellows.COUNT)
"""Pressures to hold [Pa]."""


@pytest.fixture(scope="class")
def lone_simulator(start_shared_graph: StartGraph) -> RunningGraph:
    return start_shared_graph(
        only=["simulator"],
        start_paused=True,
        parameters={
            "simulator": {
                "lockstep_timeout": 1.0,
                "command_timeout": 0.5,
                "vent_rate": 6e4,
                "max_pressure": 1e5,  # below what the robot itself can take
            }
        },
    )


class TestRobotAlone:
    """The simulator under commands given by hand."""

    @pytest.fixture
    def hand(self, lone_simulator: RunningGraph) -> Hand:
        return Hand(lone_simulator)

    def test_a_malformed_command_moves_nothing(self, hand: Hand) -> None:
        make, faults, _ = TOPICS["pressure_command"]
        hand.drive(SOME, 120)
        before = int(hand.graph.fresh("simulator")["pressure_command dropped"])
        begin, sent = hand.state(), 0
        for spoil, _ in faults.values():

            def push(stamp: int, spoil: Callable[[Any, int], None] = spoil) -> None:
                message = make(stamp)
                spoil(message, stamp)
                hand.publisher.publish(message)

            hand.drive(SOME, 15, after=push)
            sent += 15
        hand.drive(SOME, 10)
        _, pressures = hand.curve(begin)
        assert np.abs(pressures - SOME).max() < 2e3
        hand.graph.wait(
            lambda: dropped(hand.graph, "simulator", "pressure_command") >= before + sent,
            "the count",
        )
        assert dropped(hand.graph, "simulator", "pressure_command") == before + sent

    def test_pressures_out_of_range_are_clipped(self, hand: Hand) -> None:
        wished = np.array([9e5, -9e5, 5e4] * 3)
        hand.drive(wished, 200)
        within = np.clip(wished, 0.0, 1e5)
        assert np.abs(hand.pressures() - within).max() < 2e3
        assert hand.graph.fresh("simulator")["state"] == "running"

    def test_a_silent_commander_vents_at_a_limited_rate(self, hand: Hand) -> None:
        hand.drive(SOME, 120)
        begin = hand.state()
        hand.graph.wait(lambda: hand.pressures().max() < 500.0, "vented bellows")
        assert "no valid pressure_command" in hand.graph.fresh("simulator")["summary"]
        times, pressures = hand.curve(begin)
        times = times - begin * 1e-9
        # Nothing happens before the timeout; then it takes 7e4 / 6e4 s, and the lag of the valve.
        assert np.abs(pressures[times < 0.5] - SOME).max() < 2e3
        fall = -np.diff(pressures, axis=0) / np.diff(times)[:, np.newaxis]
        assert np.quantile(fall, 0.9) < 6e4 * 1.2
        vented = times[np.argmax(pressures.max(axis=1) < 0.1 * SOME.max())]
        assert 0.5 + 0.9 * SOME.max() / 6e4 < vented < 0.5 + SOME.max() / 6e4 + 1.0
        # A new command is all it needs.
        hand.drive(SOME, 120)
        assert np.abs(hand.pressures() - SOME).max() < 2e3
        assert hand.graph.fresh("simulator")["state"] == "running"

    def test_the_emergency_stop_is_latched_while_commands_go_on(self, hand: Hand) -> None:
        hand.drive(SOME, 120)
        assert "emergency_stop_reset" in hand.graph.client.emergency_stop()
        hand.drive(SOME, 150)  # 3 s; venting 7e4 Pa takes 1.75 s
        assert hand.pressures().max() < 500.0
        assert "emergency stop" in hand.graph.fresh("simulator")["summary"]
        assert "ended" in hand.graph.client.emergency_stop_reset()
        # The command in force was given before the reset, and its answer to the state is there.
        begin = hand.state()
        hand.publisher.publish(pressures_message(begin, SOME))
        hand.graph.wait(lambda: hand.state() > begin + 1 * SECOND, "1 s after the reset")
        assert hand.pressures().max() < 500.0
        assert "no valid pressure_command" in hand.graph.fresh("simulator")["summary"]
        hand.drive(SOME, 120)
        assert np.abs(hand.pressures() - SOME).max() < 2e3

    def test_a_reset_of_the_robot_keeps_the_emergency_stop(self, hand: Hand) -> None:
        hand.drive(SOME, 120)
        hand.graph.client.emergency_stop()
        try:
            hand.graph.client.reset()
            begin = hand.state()
            hand.drive(SOME, 50)
            assert hand.graph.fresh("simulator")["state"] == "stopped"
            assert hand.curve(begin + SECOND // 10)[1].max() < 500.0
        finally:
            hand.graph.client.emergency_stop_reset()

    def test_a_fresh_robot_stays_vented_until_a_new_command(self, hand: Hand) -> None:
        hand.drive(SOME, 120)
        hand.graph.client.reset()
        begin = hand.state()
        hand.graph.wait(lambda: hand.state() > begin + 1 * SECOND, "1 s of silence")
        assert hand.curve(begin + SECOND // 10)[1].max() < 500.0
        hand.drive(SOME, 120)
        assert np.abs(hand.pressures() - SOME).max() < 2e3


def test_the_safe_state_can_hold(start_graph: StartGraph) -> None:
    hand = Hand(
        start_graph(
            only=["simulator"],
            start_paused=True,
            parameters={
                "simulator": {
                    "lockstep_timeout": 0.3,
                    "command_timeout": 0.5,
                    "safe_state": "hold",
                }
            },
        )
    )
    hand.drive(SOME, 120)
    begin = hand.state()
    hand.graph.wait(lambda: hand.state() > begin + 3 * SECOND, "3 s of silence")
    assert "safe state" in hand.graph.fresh("simulator")["summary"]
    assert np.abs(hand.pressures() - SOME).max() < 2e3


class LengthHand:
    """Commands lengths once a command period, in the place of the learner."""

    def __init__(self, graph: RunningGraph) -> None:
        self.graph = graph
        self.publisher = graph.publisher("length_command")
        self.outputs = graph.listen("pressure_command")

    def hold(self, lengths: np.ndarray, duration: float) -> None:
        """Command lengths (9,) [m] for a robot time [s]."""
        end = self.graph.now() + round(duration * SECOND)
        while (now := self.graph.now()) < end:
            self.publisher.publish(lengths_message(now, lengths))
            self.graph.wait(lambda now=now: self.graph.now() > now, "the next state")


def start_controller(start: StartGraph, **parameters: Any) -> RunningGraph:
    graph = start(
        only=["simulator", "pressure_ctrl"],
        real_time_factor=3.0,
        parameters={"pressure_ctrl": parameters},
    )
    graph.wait(
        lambda: "no lengths" not in graph.values("pressure_ctrl")["summary"],
        "the controller seeing the robot",
    )
    return graph


@pytest.fixture(scope="class")
def lone_controller(start_shared_graph: StartGraph) -> RunningGraph:
    return start_controller(
        start_shared_graph, **{"safety.command_timeout": 1.0, "safety.vent_rate": 5e4}
    )


class TestControllerAlone:
    """Simulator and controller under length commands given by hand."""

    @pytest.fixture
    def hand(self, lone_controller: RunningGraph) -> LengthHand:
        return LengthHand(lone_controller)

    def test_it_vents_when_the_commander_is_silent(self, hand: LengthHand) -> None:
        hand.hold(np.full(bellows.COUNT, 0.21), 5.0)
        assert hand.graph.pressures().max() > 3e4
        # The newest diagnostics came while commands did; the next may come too late.
        assert hand.graph.values("pressure_ctrl")["mode"] == "control"
        begin = len(hand.outputs.messages)
        hand.graph.wait(lambda: hand.graph.pressures().max() < 500.0, "vented bellows")
        values = hand.graph.fresh("pressure_ctrl")
        assert values["mode"] == "no command"
        assert "no valid length_command" in values["summary"]
        # The controller vents by itself, at its own rate; to the robot it is not silent.
        assert hand.graph.fresh("simulator")["state"] == "running"
        venting = np.array([message.pressure for message in hand.outputs.messages[begin:]])
        fall = -np.diff(venting[-60:], axis=0)
        assert fall.max() <= 5e4 * 0.02 * 1.001
        hand.hold(np.full(bellows.COUNT, 0.21), 3.0)
        assert hand.graph.pressures().max() > 3e4

    def test_lengths_out_of_range_give_pressures_within_it(self, hand: LengthHand) -> None:
        measured = hand.graph.listen("lengths")
        begin = len(hand.outputs.messages)
        wished = np.array([5.0, -5.0, 0.2] * 3)
        hand.hold(wished, 5.0)
        outputs = np.array([message.pressure for message in hand.outputs.messages[begin:]])
        assert outputs.min() == 0.0
        assert outputs.max() == bellows.MAX_PRESSURE
        assert np.all(hand.graph.pressures()[0::3] > bellows.MAX_PRESSURE - 2e3)
        assert np.all(hand.graph.pressures()[1::3] < 2e3)
        # It comes back from there.
        for _ in range(10):
            hand.hold(np.full(bellows.COUNT, 0.2), 3.0)
            if np.abs(np.array(measured.last.position) - 0.2).max() < 0.01:
                return
        pytest.fail(f"still at {measured.last.position} after 30 s")


def test_the_controller_can_hold_instead(start_graph: StartGraph) -> None:
    graph = start_controller(
        start_graph, **{"safety.command_timeout": 0.5, "safety.safe_state": "hold"}
    )
    hand = LengthHand(graph)
    hand.hold(np.full(bellows.COUNT, 0.21), 5.0)
    graph.wait_robot(3.0)
    assert graph.fresh("pressure_ctrl")["mode"] == "no command"
    assert graph.pressures().max() > 3e4


# --- goals -------------------------------------------------------------------------------------


def goal(x: float, y: float, z: float, frame: str = "") -> PointStamped:
    message = PointStamped(point=Point(x=x, y=y, z=z))
    message.header.frame_id = frame
    return message


BAD_GOALS = {
    "NaN": (goal(math.nan, 0.0, 0.8), "not finite"),
    "inf": (goal(0.0, math.inf, 0.8), "not finite"),
    "wrong frame": (goal(0.0, 0.0, 0.8, "world"), "frame_id is 'world'"),
    "far outside": (goal(3.0, 0.0, 0.8), "the goal is refused"),
}
NODES = ("learner", "cartesian_feedback")


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

    @pytest.mark.parametrize("node", NODES)
    @pytest.mark.parametrize("fault", BAD_GOALS)
    def test_a_bad_goal(self, graph: RunningGraph, node: str, fault: str) -> None:
        before = graph.listen("length_command").last.position
        where, reason = BAD_GOALS[fault]
        for message in why_refused(graph, node, where):
            assert reason in message
        graph.wait_robot(1.0)
        assert graph.listen("length_command").last.position == before

    @pytest.mark.parametrize("node", NODES)
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
        assert "duration must be above 0 s" in graph.log("learner")

    def test_too_few_samples_to_identify(self, graph: RunningGraph) -> None:
        handle = graph.begin(Identify, "pressure_ctrl/identify", Identify.Goal(samples=3))
        assert not handle.accepted
        assert "at least 20" in graph.log("pressure_ctrl")

    def test_while_it_babbles(self, graph: RunningGraph) -> None:
        handle = graph.begin(Babble, "learner/babble", Babble.Goal(duration=3600.0))
        graph.wait(lambda: graph.client.status.mode == LearningStatus.BABBLING, "babbling")
        for node in NODES:
            for message in why_refused(graph, node, goal(*GOAL)):
                assert "it babbles and accepts nothing else" in message
        second = graph.begin(Babble, "learner/babble", Babble.Goal(duration=10.0))
        assert not second.accepted
        # A target that somebody publishes is refused as well, and counted.
        before = int(graph.fresh("learner")["target dropped"])
        graph.publisher("target").publish(point_message(graph.now(), GOAL))
        graph.wait(lambda: dropped(graph, "learner", "target") == before + 1, "one drop")
        assert graph.client.status.mode == LearningStatus.BABBLING
        handle.cancel_goal_async()
        assert "kept" in graph.result(handle).message
        graph.wait(lambda: graph.client.status.mode == LearningStatus.HOLDING, "holding")

    def test_during_an_emergency_stop(self, graph: RunningGraph) -> None:
        graph.client.emergency_stop()
        try:
            graph.wait(lambda: graph.client.status.mode == LearningStatus.STOPPED, "stopped")
            for node in NODES:
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


# --- the emergency stop of the whole graph -----------------------------------------------------


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
        graph.wait(lambda: graph.pressures().max() < 500.0, "vented bellows")
        graph.client.emergency_stop_reset()
        graph.wait(lambda: graph.client.status.mode == LearningStatus.IDLE, "idle")
        # Holding the vented lengths takes no more pressure than the model is wrong by.
        assert self._highest(graph, 8.0) < 2e4
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
        for node in NODES:
            handle = graph.begin(
                ReachGoal,
                f"{node}/reach_goal",
                ReachGoal.Goal(goal=goal(*GOAL), tolerance=1e-6, timeout=600.0),
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
        graph.wait(lambda: graph.pressures().max() < 500.0, "vented bellows")
        graph.client.emergency_stop_reset()
        graph.wait(lambda: graph.client.status.mode == LearningStatus.IDLE, "idle")
        assert self._highest(graph, 4.0) < 2e4
        assert graph.client.status.samples == result.status.samples
        graph.client.set_goal(GOAL)

    def _highest(self, graph: RunningGraph, duration: float) -> float:
        """The highest pressure over a robot time [s]."""
        pressures = graph.listen("pressures")
        begin = len(pressures.messages)
        graph.wait_robot(duration)
        return max(max(message.pressure) for message in pressures.messages[begin:])
