"""The frame of every node: what is served between two messages of a stream."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Iterator

import pytest
import rclpy
from bha_interfaces.action import Babble
from rclpy.action import ActionClient, ActionServer, GoalResponse
from rclpy.action.server import ServerGoalHandle

from bha_common.ros_node import BhaNode
from running_graph import PATIENCE, ros_domain


class _Accepting(BhaNode):
    """Counts its rounds, and notes in which an action was accepted and in which it began."""

    def __init__(self) -> None:
        super().__init__("accepting")
        self.rounds = self.accepted_in = self.begun_in = 0
        self.action = ActionServer(
            self, Babble, "~/babble", self._begin, goal_callback=self._accept
        )

    def work(self) -> float:
        self.rounds += 1
        return super().work()

    def _accept(self, goal: Babble.Goal) -> GoalResponse:
        self.accepted_in = self.rounds
        return GoalResponse.ACCEPT

    async def _begin(self, handle: ServerGoalHandle) -> Babble.Result:
        self.begun_in = self.rounds
        handle.succeed()
        return Babble.Result()


@pytest.fixture
def accepting() -> Iterator[_Accepting]:
    """Return such a node that runs."""
    with ros_domain():
        rclpy.init(args=[])
        node = _Accepting()

        def spin() -> None:
            with contextlib.suppress(Exception):  # of a wait that the shutdown breaks off
                node.spin()

        spinning = threading.Thread(target=spin)
        spinning.start()
        try:
            yield node
        finally:
            rclpy.shutdown()
            spinning.join(PATIENCE)
            node.destroy_node()


def test_an_action_begins_in_the_round_that_accepts_it(accepting: _Accepting) -> None:
    client_node = rclpy.create_node("client")
    client = ActionClient(client_node, Babble, "accepting/babble")
    assert client.wait_for_server(PATIENCE)
    for _ in range(5):
        answer = client.send_goal_async(Babble.Goal(duration=1.0))
        rclpy.spin_until_future_complete(client_node, answer, timeout_sec=PATIENCE)
        ended = answer.result().get_result_async()
        rclpy.spin_until_future_complete(client_node, ended, timeout_sec=PATIENCE)
        assert ended.done()
        assert accepting.begun_in == accepting.accepted_in
    client.destroy()
    client_node.destroy_node()
