"""What a user of the graph calls: the services and actions of its nodes, from Python."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from bha_interfaces.action import Babble, Identify, ReachGoal
from bha_interfaces.msg import Pressures
from bha_interfaces.srv import LoadModel, Reset, SaveModel, SetGoal
from geometry_msgs.msg import PoseStamped
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState, GetState
from numpy.typing import NDArray
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from bha_bringup.recording import Recording
from bha_bringup.robot_connection import CALL_TIMEOUT, RobotConnection, RobotError
from bha_common.ros_messages import (
    lengths_from,
    nanoseconds,
    point_message,
    pressures_from,
    pressures_message,
    tip_from,
)
from bha_common.ros_node import CONTROL_QOS, WATCHER_QOS

Array = NDArray[np.float64]
LEARNER, CONTROLLER = "learner", "pressure_ctrl"
FEEDBACK, SIMULATOR, DRIVER = "cartesian_feedback", "simulator", "driver"

IdentifyFeedback, BabbleFeedback, ReachFeedback = (
    Identify.Feedback,
    Babble.Feedback,
    ReachGoal.Feedback,
)


@dataclass(frozen=True, eq=False)
class Reached:
    """How a movement to a goal ended.

    Attributes
    ----------
    success : Whether it ended by itself.
    message : What happened, for people.
    tip : Where the tip came to [m], shape (3,).
    error : Distance to the goal in the task's coordinates [m].
    duration : Robot time that it took [s].
    """

    success: bool
    message: str
    tip: Array
    error: float
    duration: float


class RobotClient(RobotConnection):
    """The services and actions of the graph as calls; a context manager."""

    def wait_for_graph(
        self, nodes: set[str], timeout: float = 60.0, *, chained: bool = True
    ) -> None:
        """Wait until every one of the nodes answers, and the controller hears the learner.

        The latter needs a robot that tells its state; without `chained` it is not waited for.

        In lockstep many seconds of robot time may pass while nodes find one another; who begins
        earlier would see a robot that does not follow.

        Raises
        ------
        RobotError
            Naming the nodes that are missing.
        """
        if not self.wait(lambda: nodes <= self.nodes(), timeout):
            missing = ", ".join(sorted(nodes - self.nodes()))
            raise RobotError(f"no {missing} within {timeout:g} s: is the graph up (bha up)?")
        for kind, name in (
            (Identify, f"{CONTROLLER}/identify"),
            (Babble, f"{LEARNER}/babble"),
            (ReachGoal, f"{LEARNER}/reach_goal"),
            (ReachGoal, f"{FEEDBACK}/reach_goal"),
        ):
            if name.split("/")[0] in nodes:
                self.action(kind, name)
        chained = chained and {LEARNER, CONTROLLER} <= nodes
        if chained and not self.wait(self._is_chained, timeout):
            raise RobotError(f"no commands of the learner reach the controller in {timeout:g} s")

    def _is_chained(self) -> bool:
        """Whether commands flow; from a paused robot nothing flows, and that is well."""
        simulator = self.diagnostics.get(SIMULATOR)
        if simulator is not None and simulator.message == "paused":
            return True
        controller = self.diagnostics.get(CONTROLLER)
        return controller is not None and any(
            item.key == "commander" and item.value == "alive" for item in controller.values
        )

    def identify(
        self, samples: int = 0, progress: Callable[[Identify.Feedback], None] | None = None
    ) -> Identify.Result:
        """Let the controller learn its equilibrium model; 0 samples takes its parameter."""
        goal = Identify.Goal(samples=samples)
        return self.run(Identify, f"{CONTROLLER}/identify", goal, progress)

    def babble(
        self,
        duration: float,
        *,
        restart: bool = False,
        progress: Callable[[Babble.Feedback], None] | None = None,
    ) -> Babble.Result:
        """Let the learner explore for a robot time [s]."""
        goal = Babble.Goal(duration=float(duration), restart=restart)
        return self.run(Babble, f"{LEARNER}/babble", goal, progress)

    def reach(
        self,
        tip: Array,
        *,
        feedback: bool = False,
        tolerance: float = 0.0,
        timeout: float = 0.0,
        progress: Callable[[ReachGoal.Feedback], None] | None = None,
    ) -> Reached:
        """Go to a goal (3,) [m] and wait for the end, with or without Cartesian feedback."""
        goal = ReachGoal.Goal(
            goal=point_message(0, np.asarray(tip)), tolerance=tolerance, timeout=timeout
        )
        name = FEEDBACK if feedback else LEARNER
        result = self.run(ReachGoal, f"{name}/reach_goal", goal, progress)
        tip = np.array([result.tip.x, result.tip.y, result.tip.z])
        return Reached(result.success, result.message, tip, result.error, result.duration)

    def set_goal(self, tip: Array, *, feedback: bool = False) -> str:
        """Set a goal (3,) [m] and come back at once; what the node says to it."""
        name = FEEDBACK if feedback else LEARNER
        request = SetGoal.Request(goal=point_message(0, np.asarray(tip)))
        response = self.call(SetGoal, f"{name}/set_goal", request)
        if not response.accepted:
            raise RobotError(f"{name}: {response.message}")
        return str(response.message)

    def save(self, node: str, path: str = "") -> str:
        """Save the model of the learner or the controller; where it was written."""
        response = self.call(SaveModel, f"{node}/save_model", SaveModel.Request(path=path))
        return self._success(node, response)

    def load(self, node: str, path: str = "") -> str:
        """Load a model into the learner or the controller; what was loaded."""
        response = self.call(LoadModel, f"{node}/load_model", LoadModel.Request(path=path))
        return self._success(node, response)

    def pause(self, paused: bool) -> str:
        """Pause the simulator, or let it go on."""
        response = self.call(SetBool, f"{SIMULATOR}/pause", SetBool.Request(data=paused))
        return self._success(SIMULATOR, response)

    def reset(self, seed: int | None = None) -> str:
        """Put a fresh robot in the place of the simulated one."""
        request = Reset.Request(use_seed=seed is not None, seed=seed or 0)
        return self._success(SIMULATOR, self.call(Reset, f"{SIMULATOR}/reset", request))

    def set_parameters(self, node: str, values: Mapping[str, Any]) -> None:
        """Set parameters of a node, all of them or none.

        Raises
        ------
        RobotError
            When the node refuses, with its reason.
        """
        parameters = [
            Parameter(name, value=list(value) if isinstance(value, tuple) else value)
            for name, value in values.items()
        ]
        request = SetParametersAtomically.Request(
            parameters=[parameter.to_parameter_msg() for parameter in parameters]
        )
        name = f"{node}/set_parameters_atomically"
        result = self.call(SetParametersAtomically, name, request).result
        if not result.successful:
            raise RobotError(f"{node}: {result.reason}")

    def emergency_stop(self) -> str:
        """Stop the robot; it stays in its safe state until `emergency_stop_reset`."""
        return self._success("robot", self.call(Trigger, "emergency_stop", Trigger.Request()))

    def emergency_stop_reset(self) -> str:
        """End the emergency stop."""
        response = self.call(Trigger, "emergency_stop_reset", Trigger.Request())
        return self._success("robot", response)

    def change_driver(self, transition: str) -> str:
        """Bring the driver of the pneumatics to another state, such as ``activate``; its state."""
        request = ChangeState.Request(transition=Transition(label=transition))
        answer = self.call(ChangeState, f"{DRIVER}/change_state", request)
        state = self.call(GetState, f"{DRIVER}/get_state", GetState.Request())
        label = str(state.current_state.label)
        if not answer.success:
            raise RobotError(
                f"{DRIVER} does not {transition}, it is {label}; its log and bha status say why"
            )
        return label

    def press(self, pressures: Array, duration: float) -> Array:
        """Command pressures (9,) [Pa] by hand for a wall time [s]; the lengths (9,) [m] at its end.

        Raises
        ------
        RobotError
            When somebody else commands pressures, or no lengths come.
        """
        if self.node.count_publishers("pressure_command"):
            raise RobotError("the controller commands the pressures: start the driver alone")
        seen = Recording()
        end_recording = self.record(seen)
        publisher = self.node.create_publisher(Pressures, "pressure_command", CONTROL_QOS)
        try:
            if not self.wait(lambda: bool(seen.lengths), CALL_TIMEOUT):
                raise RobotError("no lengths come: is the driver configured?")
            deadline = time.monotonic() + duration
            while time.monotonic() < deadline:
                stamp = round(seen.lengths[-1][0] * 1e9)
                publisher.publish(pressures_message(stamp, np.asarray(pressures)))
                self.wait(lambda: False, 0.1)
        finally:
            end_recording()
            self.node.destroy_publisher(publisher)
        return seen.lengths[-1][1]

    def record(self, into: Recording) -> Callable[[], None]:
        """Begin to record; call what is returned to end it."""

        def keep(store: list[tuple[float, Array]], read: Callable[[Any], Array]) -> Any:
            return lambda message: store.append(
                (nanoseconds(message.header.stamp) * 1e-9, read(message))
            )

        subscribe = self.node.create_subscription
        subscriptions = [
            subscribe(JointState, "lengths", keep(into.lengths, lengths_from), WATCHER_QOS),
            subscribe(JointState, "length_command", keep(into.commands, lengths_from), CONTROL_QOS),
            subscribe(Pressures, "pressures", keep(into.pressures, pressures_from), WATCHER_QOS),
            subscribe(PoseStamped, "tip", keep(into.tips, tip_from), WATCHER_QOS),
        ]
        self.wait(lambda: bool(into.lengths and into.tips), timeout=2.0)

        def end() -> None:
            for subscription in subscriptions:
                self.node.destroy_subscription(subscription)

        return end

    def _success(self, node: str, response: Any) -> str:
        if not response.success:
            raise RobotError(f"{node}: {response.message}")
        return str(response.message)
