"""A connection to a running graph: hears its nodes, calls their services, runs their actions."""

from __future__ import annotations

import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from action_msgs.msg import GoalStatus
from bha_interfaces.msg import LearningStatus
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rclpy import init, ok, try_shutdown
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from bha_bringup.graph import NAMESPACE

CALL_TIMEOUT = 10.0
_TRIES = 2  # an answer is lost where the server has not found its client yet


class RobotError(RuntimeError):
    """The robot refused or did not answer; the message says which node and why."""


class RobotConnection:
    """A connection to a running graph; a context manager.

    Parameters
    ----------
    watch : Called while waiting, about ten times a second; may raise to end the wait.

    Attributes
    ----------
    node : The client's own node.
    status : The newest status of the learner; None before the first.
    diagnostics : The newest diagnostics of each node, by its name without the namespace.
    """

    def __init__(self, watch: Callable[[], None] = lambda: None) -> None:
        self._watch = watch
        self._own_context = not ok()
        if self._own_context:
            # Ctrl-C must reach Python as an exception: what runs is to be cancelled first.
            init(signal_handler_options=SignalHandlerOptions.NO)
        self.node = Node("client", namespace=NAMESPACE)
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self.status: LearningStatus | None = None
        self.diagnostics: dict[str, DiagnosticStatus] = {}
        self.node.create_subscription(LearningStatus, "learning_status", self._take_status, 1)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._take_diagnostics, 50)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the connection."""
        self._executor.shutdown(timeout_sec=0.0)
        for client in self._clients.values():
            if isinstance(client, ActionClient):  # rclpy leaves them, and with them shared memory
                client.destroy()
        self.node.destroy_node()
        if self._own_context:
            try_shutdown()

    def nodes(self) -> set[str]:
        """Names of the nodes of the graph that are there, without the namespace."""
        found = self.node.get_node_names_and_namespaces()
        return {name for name, namespace in found if namespace == NAMESPACE and name != "client"}

    def wait(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Serve messages until a condition holds, at most `timeout` [s] of wall time."""
        deadline = time.monotonic() + timeout
        watch_due = 0.0
        while not condition():
            now = time.monotonic()
            if now >= deadline:
                return False
            if now >= watch_due:
                self._watch()
                watch_due = now + 0.1
            self._executor.spin_once(timeout_sec=min(0.05, deadline - now))
        return True

    def call(self, kind: Any, name: str, request: Any) -> Any:
        """Call any service of the graph.

        Raises
        ------
        RobotError
            When it is not there or does not answer in time.
        """
        if name not in self._clients:
            self._clients[name] = self.node.create_client(kind, name)
        client = self._clients[name]
        if not self.wait(client.service_is_ready, CALL_TIMEOUT):
            raise RobotError(f"the service {name} is not there: is the graph up (bha up)?")
        for _ in range(_TRIES):
            future = client.call_async(request)
            if self.wait(future.done, CALL_TIMEOUT / _TRIES):
                break
            client.remove_pending_request(future)
        else:
            raise RobotError(f"the service {name} does not answer")
        return future.result()

    def action(self, kind: Any, name: str) -> Any:
        """Return the client of an action of the graph, once it is there.

        Raises
        ------
        RobotError
            When it is not there in time.
        """
        if name not in self._clients:
            self._clients[name] = ActionClient(self.node, kind, name)
        client = self._clients[name]
        if not self.wait(client.server_is_ready, CALL_TIMEOUT):
            raise RobotError(f"the action {name} is not there: is the graph up (bha up)?")
        return client

    def run(self, kind: Any, name: str, goal: Any, progress: Callable[..., None] | None) -> Any:
        """Run an action to its end; an exception on the way cancels it.

        Raises
        ------
        RobotError
            When it is not there, refuses the goal, or ends without having done it.
        """
        client = self.action(kind, name)

        def tell(message: Any) -> None:
            if progress is not None:
                progress(message.feedback)

        accepted = client.send_goal_async(goal, feedback_callback=tell)
        if not self.wait(accepted.done, CALL_TIMEOUT):
            raise RobotError(f"the action {name} does not answer")
        handle = accepted.result()
        if not handle.accepted:
            raise RobotError(f"{name} was refused: the log of {name.split('/')[0]} says why")
        ended = handle.get_result_async()
        try:
            self.wait(ended.done, timeout=float("inf"))
        except BaseException:
            handle.cancel_goal_async()
            self._executor.spin_once(timeout_sec=0.2)
            raise
        outcome = ended.result()
        if outcome.status == GoalStatus.STATUS_ABORTED:
            raise RobotError(f"{name}: {outcome.result.message}")
        return outcome.result

    def _take_status(self, message: LearningStatus) -> None:
        self.status = message

    def _take_diagnostics(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.diagnostics[status.name.removeprefix(f"{NAMESPACE}/")] = status


def refuse_second_graph(patience: float = 1.0) -> None:
    """Raise RobotError when nodes of a graph are there before one is started.

    Parameters
    ----------
    patience : Wall time to look for them [s].
    """
    with RobotConnection() as robot:
        if robot.wait(lambda: bool(robot.nodes()), patience):
            raise RobotError(
                "a graph is running in this ROS domain already "
                f"({', '.join(sorted(robot.nodes()))}): end it (bha stop), "
                "or choose another domain, such as ROS_DOMAIN_ID=1"
            )
