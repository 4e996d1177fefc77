"""The pressure controller under length commands given by hand: silence and ranges."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from bha_common import bellows
from bha_common.ros_messages import lengths_message
from running_graph import RunningGraph, StartGraph

pytestmark = pytest.mark.graph


class LengthHand:
    """Commands lengths once a command period, in the place of the learner."""

    def __init__(self, graph: RunningGraph) -> None:
        self.graph = graph
        self.publisher = graph.publisher("length_command")
        self.outputs = graph.listen("pressure_command")

    def hold(self, lengths: np.ndarray, condition: Callable[[], bool], what: str) -> None:
        """Command lengths (9,) [m] until a condition holds; fail when it does not in time.

        A robot time would not do: under load a command may come too late, the robot vents, and
        what was on its way begins anew.
        """
        told = self.graph.now()

        def step() -> bool:
            nonlocal told
            if (now := self.graph.now()) > told:
                told = now
                self.publisher.publish(lengths_message(now, lengths))
            return condition()

        self.graph.wait(step, what)


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
        hand.hold(
            np.full(bellows.COUNT, 0.21),
            # The newest diagnostics came while commands did; the next may come too late.
            lambda: (
                hand.graph.pressures().max() > 3e4
                and hand.graph.values("pressure_ctrl")["mode"] == "control"
            ),
            "bellows under pressure",
        )
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
        hand.hold(
            np.full(bellows.COUNT, 0.21),
            lambda: hand.graph.pressures().max() > 3e4,
            "bellows under pressure again",
        )

    def test_lengths_out_of_range_give_pressures_within_it(self, hand: LengthHand) -> None:
        measured = hand.graph.listen("lengths")
        begin = len(hand.outputs.messages)
        wished = np.array([5.0, -5.0, 0.2] * 3)
        hand.hold(
            wished,
            lambda: (
                hand.graph.pressures()[0::3].min() > bellows.MAX_PRESSURE - 2e3
                and hand.graph.pressures()[1::3].max() < 2e3
            ),
            "full and empty bellows",
        )
        outputs = np.array([message.pressure for message in hand.outputs.messages[begin:]])
        assert outputs.min() == 0.0
        assert outputs.max() == bellows.MAX_PRESSURE
        hand.hold(
            np.full(bellows.COUNT, 0.2),
            lambda: np.abs(np.array(measured.last.position) - 0.2).max() < 0.01,
            "lengths in range again",
        )


def test_the_controller_can_hold_instead(start_graph: StartGraph) -> None:
    graph = start_controller(
        start_graph, **{"safety.command_timeout": 0.5, "safety.safe_state": "hold"}
    )
    hand = LengthHand(graph)
    hand.hold(
        np.full(bellows.COUNT, 0.21),
        lambda: graph.pressures().max() > 4e4,
        "bellows under pressure",
    )
    graph.wait_robot(3.0)
    assert graph.fresh("pressure_ctrl")["mode"] == "no command"
    assert graph.pressures().max() > 3e4
