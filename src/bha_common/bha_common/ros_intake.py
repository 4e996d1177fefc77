"""One gate for everything that comes in: bad messages are dropped whole, counted and named."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bha_common.ros_messages import MessageError
from bha_common.stamps import StampError

_LOG_PERIOD = 1.0


class Intake:
    """Wraps a callback so that a message it refuses is dropped, counted and logged.

    Parameters
    ----------
    node : Who logs.
    topic : Name of the topic, for people.
    callback : Takes the message; raises MessageError or StampError to refuse it.
    """

    def __init__(self, node: Node, topic: str, callback: Callable[[Any], None]) -> None:
        self._node = node
        self._topic = topic
        self._callback = callback
        self.dropped = 0
        self.reason = ""

    def __call__(self, message: Any) -> None:
        """Pass a message on, or drop it."""
        try:
            self._callback(message)
        except (MessageError, StampError) as error:
            self.dropped += 1
            self.reason = str(error)
            self._node.get_logger().warning(
                f"dropped a message on {self._topic}: {error} ({self.dropped} so far)",
                throttle_duration_sec=_LOG_PERIOD,
            )

    def values(self) -> dict[str, str]:
        """Tell diagnostics about this topic."""
        if not self.dropped:
            return {f"{self._topic} dropped": "0"}
        return {
            f"{self._topic} dropped": str(self.dropped),
            f"{self._topic} last reason": self.reason,
        }
