"""What the actions of several nodes share."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.task import Future

from bha_common.ros_node import BhaNode

_PERIOD = 0.2  # [s] of wall time


async def with_progress(node: BhaNode, done: Future, tell: Callable[[], None]) -> None:
    """Wait until something is done, and tell of it five times a second until then."""
    timer = node.create_timer(_PERIOD, tell, clock=node.steady_clock)
    await done
    node.destroy_timer(timer)
