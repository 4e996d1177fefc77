"""Subscriptions whose messages go past the executor."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rclpy.callback_groups import CallbackGroup
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile


class _OwnLoop(CallbackGroup):
    """Keeps subscriptions out of the executor: `Streams` takes their messages itself."""

    def can_execute(self, entity: Any) -> bool:
        return False

    def beginning_execution(self, entity: Any) -> bool:
        return False

    def ending_execution(self, entity: Any) -> None:
        return None


class Streams:
    """The streams of a node, with a wait set of their own.

    rclpy's executor looks at every entity of a node for every message, 0.3 to 0.5 ms for a node
    with some services and an action. Lockstep needs a thousand states a second, so the streams of
    the control chain are waited for apart from everything else.

    Parameters
    ----------
    node : The node that they belong to.
    qos : Their quality of service.
    """

    def __init__(self, node: Node, qos: QoSProfile) -> None:
        self._node = node
        self._qos = qos
        self._own_loop = _OwnLoop()
        self._subscriptions: list[Any] = []

    def add(self, message_type: Any, topic: str, callback: Callable[[bytes], None]) -> None:
        """Subscribe to a topic; the callback takes messages as they came over the wire."""
        self._subscriptions.append(
            self._node.create_subscription(
                message_type, topic, callback, self._qos, callback_group=self._own_loop, raw=True
            )
        )

    def taker(self) -> Callable[[float], None]:
        """Return what waits for the streams that there are, at most some seconds of wall time.

        It hands over one message of each stream that has some.
        """
        subscriptions = list(self._subscriptions)
        handles = [subscription.handle for subscription in subscriptions]
        if not handles:
            return time.sleep  # an empty wait set cannot be waited on
        context = self._node.context.handle
        wait_set = rclpy_implementation.WaitSet(len(handles), 0, 0, 0, 0, 0, context)

        def take(timeout: float) -> None:
            wait_set.clear_entities()
            for handle in handles:
                wait_set.add_subscription(handle)
            wait_set.wait(int(timeout * 1e9))
            ready = wait_set.get_ready_entities("subscription")
            for subscription in subscriptions:
                if subscription.handle.pointer in ready:
                    taken = subscription.handle.take_message(
                        subscription.msg_type, subscription.raw
                    )
                    if taken is not None:
                        subscription.callback(taken[0])

        return take
