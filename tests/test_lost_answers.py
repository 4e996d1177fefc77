"""A service whose answer was lost is asked again."""

from typing import Any

import pytest
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from rclpy.task import Future
from std_srvs.srv import Trigger

from bha_bringup import robot_connection
from bha_bringup.graph import NAMESPACE
from bha_bringup.robot_connection import RobotConnection, RobotError
from running_graph import ros_domain

pytestmark = pytest.mark.graph


@pytest.mark.parametrize(("lost", "answered"), [(1, True), (9, False)])
def test_a_lost_answer(monkeypatch: pytest.MonkeyPatch, lost: int, answered: bool) -> None:
    """As of a server that has not found its client yet; but not for ever."""
    monkeypatch.setattr(robot_connection, "CALL_TIMEOUT", 4.0)
    requests = []

    async def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        requests.append(response)
        if len(requests) <= lost:
            await Future()
        response.success = True
        return response

    with ros_domain(), RobotConnection() as robot:
        server = Node("server", namespace=NAMESPACE)
        group = ReentrantCallbackGroup()  # one that waits keeps no other from being served
        server.create_service(Trigger, "thing", answer, callback_group=group)
        executor: Any = robot._executor
        executor.add_node(server)
        if answered:
            assert robot.call(Trigger, "thing", Trigger.Request()).success
        else:
            with pytest.raises(RobotError, match="thing does not answer"):
                robot.call(Trigger, "thing", Trigger.Request())
        server.destroy_node()
    assert len(requests) == 2
