"""A graph of nodes under test: its processes, a client, what it published, and its ROS domain."""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import os
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
import rclpy
from ament_index_python.packages import get_package_prefix
from bha_interfaces.action import ReachGoal
from bha_interfaces.msg import LearningStatus, Pressures
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point, PointStamped, PoseStamped
from sensor_msgs.msg import JointState

from bha_bringup.graph import GraphSettings, NodeDescription, describe_graph
from bha_bringup.graph_processes import GraphProcesses
from bha_bringup.robot_client import RobotClient
from bha_common.ros_messages import nanoseconds
from bha_common.ros_node import CONTROL_QOS

TYPES: dict[str, Any] = {
    "/diagnostics": DiagnosticArray,
    "lengths": JointState,
    "length_command": JointState,
    "pressures": Pressures,
    "pressure_command": Pressures,
    "tip": PoseStamped,
    "target": PointStamped,
    "learning_status": LearningStatus,
}
"""Type of every topic of the graph that tests look at or write to."""

ROBOT = "bha_sim_0"
"""Name that the graph gives to the simulated robot of seed 0."""

SECOND = 1_000_000_000
"""Nanoseconds."""

GOAL = np.array([0.10, 0.05, 0.78])
"""A goal that the robot of these tests has learned to reach [m], shape (3,)."""

NODES_OF_GOALS = ("learner", "cartesian_feedback")
"""The nodes that goals can be given to."""

PATIENCE = 60.0
"""Wall time that a wait may last [s]: much longer than it takes on a machine that is busy."""

StartGraph = Callable[..., "RunningGraph"]
"""Starts a graph; the parameters are those of the function in conftest.py."""

RUNNING: list[RunningGraph] = []
"""The graphs that run now, for the report of a failure."""


@contextlib.contextmanager
def ros_domain() -> Iterator[int]:
    """Hold a ROS domain that no other test on this machine holds, and put it in the environment."""
    folder = Path(tempfile.gettempdir(), f"bha_test_domains_{os.getuid()}")
    folder.mkdir(exist_ok=True)
    for turn in range(101):
        domain = 1 + (os.getpid() + turn) % 101
        lock = (folder / str(domain)).open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            lock.close()
            continue
        before = os.environ.get("ROS_DOMAIN_ID")
        os.environ["ROS_DOMAIN_ID"] = str(domain)
        try:
            yield domain
        finally:
            lock.close()
            if before is None:
                del os.environ["ROS_DOMAIN_ID"]
            else:
                os.environ["ROS_DOMAIN_ID"] = before
        return
    raise RuntimeError("no ROS domain is free: 101 test runs at once?")


def refused_node(package: str, node: str, *arguments: str) -> str:
    """Start a node with arguments that it must refuse; what it says as it ends with code 2."""
    with ros_domain() as domain:
        ended = subprocess.run(
            [Path(get_package_prefix(package), "lib", package, node), "--ros-args", *arguments],
            env={**os.environ, "ROS_DOMAIN_ID": str(domain)},
            capture_output=True,
            text=True,
            timeout=60.0,
            check=False,
        )
    assert ended.returncode == 2, ended.stderr
    assert "Traceback" not in ended.stderr
    return ended.stderr


def describe(
    settings: GraphSettings,
    *,
    only: Sequence[str] = (),
    parameters: dict[str, dict[str, Any]] | None = None,
) -> list[NodeDescription]:
    """Describe a graph, or some of its nodes, with parameters of the test's own."""
    return [
        dataclasses.replace(
            node, parameters={**node.parameters, **(parameters or {}).get(node.executable, {})}
        )
        for node in describe_graph(settings)
        if not only or node.executable in only
    ]


class _Processes(GraphProcesses):
    """Processes that a test may end on purpose."""

    def __init__(self, nodes: Sequence[NodeDescription], folder: Path) -> None:
        super().__init__(nodes, folder)
        self.may_end: set[str] = set()

    def check(self) -> None:
        ended = [name for name in self.may_end if name in self._processes]
        kept = {name: self._processes.pop(name) for name in ended}
        try:
            super().check()
        finally:
            self._processes.update(kept)

    def code(self, name: str, timeout: float) -> int:
        """Wait for a process to end, and give its exit code."""
        return self._processes[name].wait(timeout)


class Stream:
    """What came in on a topic since the test began to listen."""

    def __init__(self) -> None:
        self.messages: list[Any] = []

    @property
    def last(self) -> Any:
        return self.messages[-1]

    @property
    def time(self) -> float:
        """Robot time of the newest message [s]; 0 before the first."""
        return nanoseconds(self.last.header.stamp) * 1e-9 if self.messages else 0.0


class RunningGraph:
    """Nodes that run in a ROS domain of their own, and a client of theirs.

    Parameters
    ----------
    nodes : What runs.
    folder : For parameters and logs.
    """

    def __init__(self, nodes: Sequence[NodeDescription], folder: Path) -> None:
        self.names = {node.executable for node in nodes}
        self.folder = folder
        self.processes = _Processes(nodes, folder / "logs")
        self._stack = contextlib.ExitStack()
        self._streams: dict[str, Stream] = {}
        self._publishers: dict[str, Any] = {}
        self.client: RobotClient

    def __enter__(self) -> RunningGraph:
        assert not rclpy.ok(), "one graph at a time: another one's client is still connected"
        with contextlib.ExitStack() as stack:
            stack.enter_context(ros_domain())
            stack.enter_context(self.processes)
            self.client = stack.enter_context(RobotClient(self.processes.check))
            RUNNING.append(self)
            stack.callback(RUNNING.remove, self)
            try:
                self.client.wait_for_graph(self.names, PATIENCE)
                self.wait(
                    lambda: self.names <= self.client.diagnostics.keys(), "diagnostics of each node"
                )
            except BaseException as error:
                for name in sorted(self.names):  # it has left RUNNING when the failure is reported
                    error.add_note(f"log of {name}:\n{self.log(name)}")
                raise
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """End the nodes and the client."""
        self._stack.close()

    # --- waiting ---------------------------------------------------------------------------

    def wait(self, condition: Callable[[], bool], what: str, timeout: float = PATIENCE) -> None:
        """Serve messages until a condition holds; fail the test when it does not in time."""
        assert self.client.wait(condition, timeout), f"not within {timeout:g} s: {what}"

    def repeat(self, act: Callable[[], None], condition: Callable[[], bool], what: str) -> None:
        """Do something ten times a second until a condition holds; fail when it does not in time.

        For what a node must be told: a publisher knows of a subscriber before that knows of it, so
        what is published once may be lost.
        """
        due = 0.0

        def step() -> bool:
            nonlocal due
            if time.monotonic() >= due:
                due = time.monotonic() + 0.1
                act()
            return condition()

        self.wait(step, what)

    def wait_robot(self, duration: float) -> None:
        """Let some robot time pass [s]."""
        pressures = self.listen("pressures")
        self.wait(lambda: bool(pressures.messages), "measured pressures")
        end = pressures.time + duration
        self.wait(lambda: pressures.time >= end, f"{duration:g} s of robot time")

    def fresh(self, node: str) -> dict[str, str]:
        """Values of diagnostics that a node gives from now on, the summary among them as `summary`.

        What is on its way yet does not count: it may tell of a time before an answer that is here.
        """
        asked = time.time_ns()
        arrays = self.listen("/diagnostics")
        arrays.messages.clear()

        def told() -> list[DiagnosticStatus]:
            return [
                status
                for array in arrays.messages
                for status in array.status
                if nanoseconds(array.header.stamp) > asked and status.name.endswith(f"/{node}")
            ]

        self.wait(lambda: bool(told()), f"diagnostics of {node}")
        return _values(told()[-1])

    def values(self, node: str) -> dict[str, str]:
        """Values of a node's newest diagnostics; empty before the first."""
        status = self.client.diagnostics.get(node)
        return {} if status is None else _values(status)

    def dropped(self, node: str, topic: str) -> int:
        """How many messages on a topic a node has dropped, by its newest diagnostics."""
        return int(self.values(node)[f"{topic} dropped"])

    # --- topics ----------------------------------------------------------------------------

    def listen(self, topic: str) -> Stream:
        """Keep what is published on a topic from now on, or from when it was first asked for."""
        if topic not in self._streams:
            stream = self._streams[topic] = Stream()
            self.client.node.create_subscription(
                TYPES[topic], topic, stream.messages.append, CONTROL_QOS
            )
        return self._streams[topic]

    def publisher(self, topic: str) -> Any:
        """A publisher that every subscriber among the nodes has found."""
        if topic not in self._publishers:
            node = self.client.node
            self._publishers[topic] = publisher = node.create_publisher(
                TYPES[topic], topic, CONTROL_QOS
            )
            # Those of the client itself are found at once; the nodes' are what is waited for.
            self.wait(
                lambda: (
                    publisher.get_subscription_count() == node.count_subscribers(topic)
                    and node.count_subscribers(topic) > 0
                ),
                f"subscribers of {topic}",
            )
        return self._publishers[topic]

    def now(self) -> int:
        """Robot time of the newest measured pressures [ns]."""
        pressures = self.listen("pressures")
        self.wait(lambda: bool(pressures.messages), "measured pressures")
        return nanoseconds(pressures.last.header.stamp)

    def pressures(self) -> np.ndarray:
        """The newest measured pressures [Pa], shape (9,)."""
        self.now()
        return np.array(self.listen("pressures").last.pressure)

    def tip(self) -> np.ndarray:
        """The newest position of the tip [m], shape (3,)."""
        tips = self.listen("tip")
        self.wait(lambda: bool(tips.messages), "a tip")
        position = tips.last.pose.position
        return np.array([position.x, position.y, position.z])

    # --- actions ---------------------------------------------------------------------------

    def begin(self, kind: Any, name: str, goal: Any) -> Any:
        """Send a goal to an action without waiting for its end; its handle."""
        answer = self.client.action(kind, name).send_goal_async(goal)
        self.wait(answer.done, f"an answer of {name}")
        return answer.result()

    def begin_reach(self, node: str, goal: ReachGoal.Goal) -> Any:
        """Send a goal to a node, and wait until the learner moves to it; the handle."""
        before = self.client.status.goals_set
        handle = self.begin(ReachGoal, f"{node}/reach_goal", goal)
        self.wait(lambda: self.client.status.goals_set > before, "the movement's begin")
        return handle

    def result(self, handle: Any, timeout: float = PATIENCE) -> Any:
        """Wait for the end of what `begin` began; its result."""
        ended = handle.get_result_async()
        self.wait(ended.done, "the end of the action", timeout)
        return ended.result().result

    # --- processes -------------------------------------------------------------------------

    def end(self, name: str, how: signal.Signals, timeout: float = PATIENCE) -> tuple[int, float]:
        """Send a signal to a node; its exit code and the wall time it took to end [s]."""
        self.processes.may_end.add(name)
        begin = time.monotonic()
        os.kill(self.processes.pid(name), how)
        code = self.processes.code(name, timeout)
        return code, time.monotonic() - begin

    @contextlib.contextmanager
    def asleep(self, name: str) -> Iterator[None]:
        """Let a node do nothing for a while."""
        process = self.processes.pid(name)
        os.kill(process, signal.SIGSTOP)
        try:
            yield
        finally:
            os.kill(process, signal.SIGCONT)

    def restart(self, name: str) -> None:
        """Start a node again that has ended, and wait until it speaks.

        `values` are those of the new one then, and not what the old one has left.
        """
        self.processes.start(name)
        self.processes.may_end.discard(name)
        self.fresh(name)
        self.client.diagnostics.pop(name, None)
        self.wait(lambda: name in self.client.diagnostics, f"diagnostics of the new {name}")

    def log(self, name: str, lines: int = 15) -> str:
        """The tail of a node's log."""
        path = self.folder / "logs" / f"{name}.log"
        text = path.read_text(errors="replace") if path.exists() else ""
        return "\n".join(text.splitlines()[-lines:])


def _values(status: DiagnosticStatus) -> dict[str, str]:
    return {"summary": status.message, **{item.key: item.value for item in status.values}}


def goal(x: float, y: float, z: float, frame: str = "") -> PointStamped:
    """Return a goal as a message."""
    message = PointStamped(point=Point(x=x, y=y, z=z))
    message.header.frame_id = frame
    return message
