"""How a node takes goals: a service sets one and answers at once, an action waits for the end."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from bha_interfaces.action import ReachGoal
from bha_interfaces.srv import SetGoal
from geometry_msgs.msg import PointStamped
from numpy.typing import NDArray
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future

from bha_common.ros_messages import MessageError, plain_point
from bha_common.ros_node import BhaNode

Array = NDArray[np.float64]


class Movement(Protocol):
    """A movement to a goal: the goal [m], the distance to it now [m], and its time so far [s]."""

    @property
    def goal(self) -> Array: ...  # noqa: D102
    @property
    def error(self) -> float: ...  # noqa: D102
    @property
    def elapsed(self) -> float: ...  # noqa: D102


M = TypeVar("M", bound=Movement)


@dataclass(frozen=True)
class Mover(Generic[M]):
    """What moves to goals.

    Attributes
    ----------
    begin : Begins a movement to a goal, with a tolerance [m] and a timeout [s], of which 0 takes
        the node's own; raises MessageError, with the reason, to refuse it.
    current : The movement under way, if there is one.
    number : Number that the learner has given to the newest movement.
    halt : Ends it, and settles what waits for it.
    tip : Where the tip is on a movement [m], shape (3,); None when it was not seen.
    success : Whether a movement came to its goal; None when it has not ended by itself.
    arrived, late, ended : What is said of one that came to its goal, that did not within the time,
        and that did not end by itself.
    """

    begin: Callable[[PointStamped, float, float], Awaitable[M]]
    current: Callable[[], M | None]
    number: Callable[[], int]
    halt: Callable[[], None]
    tip: Callable[[M], Array | None]
    success: Callable[[M], bool | None]
    arrived: str
    late: str
    ended: str


class GoalServer(Generic[M]):
    """The service `~/set_goal` and the action `~/reach_goal` of a node."""

    def __init__(self, node: BhaNode, mover: Mover[M]) -> None:
        self._node = node
        self._mover = mover
        self._reached: Future | None = None
        node.create_service(SetGoal, "~/set_goal", self._set_goal)
        self._action = ActionServer(
            node,
            ReachGoal,
            "~/reach_goal",
            self._reach,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )

    @property
    def awaited(self) -> bool:
        """Whether an action waits for the end of a movement."""
        return self._reached is not None

    def settle(self) -> None:
        """Let the action that waits, if one does, tell how its movement has ended."""
        if self._reached is not None:
            self._reached.set_result(None)
            self._reached = None

    async def _set_goal(
        self, request: SetGoal.Request, response: SetGoal.Response
    ) -> SetGoal.Response:
        try:
            movement = await self._mover.begin(request.goal, 0.0, 0.0)
            response.accepted, response.number = True, self._mover.number()
            response.message = f"on the way to {np.round(movement.goal, 4).tolist()} m"
        except MessageError as error:
            response.message = str(error)
        return response

    async def _reach(self, handle: ServerGoalHandle) -> ReachGoal.Result:
        result, request, mover = ReachGoal.Result(), handle.request, self._mover
        try:
            movement = await mover.begin(request.goal, request.tolerance, request.timeout)
        except MessageError as error:
            result.message = str(error)
            handle.abort()
            return result
        self.settle()  # a movement that this one overtakes
        self._reached = done = Future()

        def tell() -> None:
            if handle.is_cancel_requested and mover.current() is movement:
                mover.halt()
            elif mover.tip(movement) is not None:
                handle.publish_feedback(ReachGoal.Feedback(**self._state(movement)))

        await self._node.with_progress(done, tell)
        state = self._state(movement)
        result.tip, result.error, result.duration = state["tip"], state["error"], state["elapsed"]
        success = mover.success(movement)
        result.success = bool(success)
        if handle.is_cancel_requested:
            result.message = "cancelled; holding"
            handle.canceled()
        elif success is None:
            result.message = mover.ended
            handle.abort()
        else:
            result.message = mover.arrived if success else mover.late
            handle.succeed()
        return result

    def _state(self, movement: M) -> dict[str, Any]:
        tip = plain_point(self._mover.tip(movement))
        return {"tip": tip, "error": movement.error, "elapsed": movement.elapsed}
