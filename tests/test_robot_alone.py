"""The simulated robot under pressure commands given by hand: ranges, silence, stop, reset."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bha_common import bellows
from bha_common.ros_messages import nanoseconds, pressures_message
from malformed_messages import TOPICS
from running_graph import SECOND, RunningGraph, StartGraph

pytestmark = pytest.mark.graph


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
            lambda: hand.graph.dropped("simulator", "pressure_command") >= before + sent,
            "the count",
        )
        assert hand.graph.dropped("simulator", "pressure_command") == before + sent

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
