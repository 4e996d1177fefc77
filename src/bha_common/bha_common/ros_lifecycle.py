"""A node with a managed life cycle: unconfigured, inactive, active, finalized."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from typing import Any

from lifecycle_msgs.msg import State
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn

from bha_common.ros_node import BhaNode

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE

UNCONFIGURED, INACTIVE, ACTIVE, FINALIZED = (
    State.PRIMARY_STATE_UNCONFIGURED,
    State.PRIMARY_STATE_INACTIVE,
    State.PRIMARY_STATE_ACTIVE,
    State.PRIMARY_STATE_FINALIZED,
)


class ManagedNode(LifecycleNodeMixin, BhaNode):
    """A `BhaNode` that is configured and activated from outside, as every ROS 2 managed node.

    A transition that is not possible in the present state is answered with a refusal; rclpy itself
    lets the exception end the node.

    Parameters
    ----------
    name : Name of the node.
    """

    def __init__(self, name: str) -> None:
        BhaNode.__init__(self, name)
        LifecycleNodeMixin.__init__(self, enable_communication_interface=True)
        answer = self._service_change_state.callback

        def checked(request: Any, response: Any) -> Any:
            try:
                return answer(request, response)
            except RuntimeError as error:  # rclpy's RCLError
                self.get_logger().warning(f"this transition is not possible now: {error}")
                response.success = False
                return response

        self._service_change_state.callback = checked
        callbacks: dict[int, Any] = self._callbacks
        for state, callback in callbacks.items():
            callbacks[state] = self._telling(callback)

    def _telling(
        self, callback: Callable[[LifecycleState], Any]
    ) -> Callable[[LifecycleState], Any]:
        """Log what breaks a transition off; rclpy goes to `on_error` without a word."""

        def tell(before: LifecycleState) -> Any:
            try:
                return callback(before)
            except Exception:
                self.get_logger().error(f"a transition broke off: {traceback.format_exc()}")
                raise

        return tell

    @property
    def life_state(self) -> int:
        """Id of the present state, such as ACTIVE."""
        return int(self._state_machine.current_state[0])

    @property
    def life_label(self) -> str:
        """Name of the present state, such as ``active``."""
        return str(self._state_machine.current_state[1])


__all__ = [
    "ACTIVE",
    "FAILURE",
    "FINALIZED",
    "INACTIVE",
    "SUCCESS",
    "UNCONFIGURED",
    "LifecycleState",
    "ManagedNode",
]
