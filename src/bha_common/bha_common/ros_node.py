"""The frame of every node: fast subscriptions, diagnostics, a clean start and end."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from numpy.typing import NDArray
from rclpy import init, try_shutdown
from rclpy.action import ActionServer
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import ParameterException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor, TimeoutException
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rclpy.task import Future

from bha_common.files import ModelFileError
from bha_common.ros_intake import Intake
from bha_common.ros_parameters import refuse_unknown
from bha_common.ros_streams import Streams
from bha_common.ros_wire import decoder

Array = NDArray[np.float64]

CONTROL_QOS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=100, reliability=ReliabilityPolicy.RELIABLE
)
"""For the control chain: lockstep must lose nothing."""

LATCHED_QOS = QoSProfile(
    history=HistoryPolicy.KEEP_LAST,
    depth=10,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
"""For states that a late comer must know, such as the emergency stop.

With some depth: who is busy must see a stop even when its reset follows at once.
"""

WATCHER_QOS = qos_profile_sensor_data
"""For those who only look on."""

_HOUSEKEEPING_PERIOD = 0.02
_DIAGNOSTICS_PERIOD = 1.0
_PROGRESS_PERIOD = 0.2
_HANDLERS_A_ROUND = 8

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


class BhaNode(Node):
    """A node whose streams go past the executor, see `Streams`.

    Services, actions and timers are served by the executor every 20 ms of wall time.

    Parameters
    ----------
    name : Name of the node.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._streams = Streams(self, CONTROL_QOS)
        self._intakes: list[Intake] = []
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self.steady_clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_DIAGNOSTICS_PERIOD, self._publish_diagnostics, clock=self.steady_clock)

    def subscribe_stream(
        self,
        message_type: Any,
        topic: str,
        callback: Callable[[int, Array], None],
    ) -> None:
        """Subscribe to a stream of a type that `ros_wire.decoder` knows.

        Parameters
        ----------
        message_type : Type of the messages.
        topic : Name of the topic.
        callback : Takes the stamp [ns] and the values of a message; it may refuse them, see
            `Intake`.
        """
        decode = decoder(message_type)
        intake = Intake(self, topic, lambda data: callback(*decode(data)))
        self._intakes.append(intake)
        self._streams.add(message_type, topic, intake)

    def diagnose(self) -> tuple[bytes, str, dict[str, str]]:
        """Tell level, summary and values for `/diagnostics`; nodes override this."""
        return OK, "running", {}

    async def with_progress(self, done: Future, tell: Callable[[], None]) -> None:
        """Wait until something is done, and tell of it now and then until it is."""
        timer = self.create_timer(_PROGRESS_PERIOD, tell, clock=self.steady_clock)
        await done
        self.destroy_timer(timer)

    def work(self) -> float:
        """Do what is due by wall time, and tell the seconds until the next call is due."""
        return _HOUSEKEEPING_PERIOD

    def close(self) -> None:
        """Do what must be done before the node ends; nodes override this."""

    def destroy_node(self) -> None:
        """Give back what the node holds of DDS, shared memory among it.

        rclpy leaves action servers out: what they hold would outlive the process in `/dev/shm`.
        """
        for waitable in list(self.waitables):
            if isinstance(waitable, ActionServer):
                waitable.destroy()
        super().destroy_node()

    def spin(self) -> None:
        """Serve streams, services, actions and timers until the context is shut down."""
        executor = SingleThreadedExecutor(context=self.context)
        executor.add_node(self)
        take = self._streams.taker()
        housekeeping_due = 0.0
        try:
            while self.context.ok():
                take(max(0.0, min(self.work(), _HOUSEKEEPING_PERIOD)))
                now = time.monotonic()
                if now >= housekeeping_due:
                    self._serve(executor)
                    housekeeping_due = now + _HOUSEKEEPING_PERIOD
        finally:
            executor.shutdown(timeout_sec=0.0)

    def _serve(self, executor: SingleThreadedExecutor) -> None:
        served: list[Any] = []
        try:
            for _ in range(_HANDLERS_A_ROUND):
                handler, _, _ = executor.wait_for_ready_callbacks(timeout_sec=0.0)
                handler()
                error = handler.exception()
                if error is not None:
                    raise error
                # The executor offers a coroutine that waits again and again: once is enough.
                if handler in served:
                    break
                served.append(handler)
        except TimeoutException:
            pass

    def _publish_diagnostics(self) -> None:
        level, summary, values = self.diagnose()
        for intake in self._intakes:
            values.update(intake.values())
        status = DiagnosticStatus(
            level=level,
            name=self.get_fully_qualified_name(),
            message=summary,
            hardware_id="bha",
            values=[KeyValue(key=key, value=value) for key, value in values.items()],
        )
        message = DiagnosticArray(status=[status])
        message.header.stamp = self.get_clock().now().to_msg()
        self._diagnostics.publish(message)


def run(make_node: Callable[[], BhaNode]) -> int:
    """Run a node until it is interrupted; the exit code for the process.

    Parameters
    ----------
    make_node : Makes the node once ROS is initialised; a ValueError it raises is a mistake of the
        user in parameters or files, and is told without a traceback.
    """
    init()
    node: BhaNode | None = None
    try:
        node = make_node()
        refuse_unknown(node)
    except (ValueError, ModelFileError, ParameterException) as error:
        sys.stderr.write(f"error: {error}\n")
        if node is not None:
            node.destroy_node()
        try_shutdown()
        return 2
    try:
        node.spin()
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except Exception as error:
        # A wait that the shutdown broke off is no error; anything else is.
        if node.context.ok():
            raise
        node.get_logger().debug(f"ended while waiting: {error}")
    finally:
        node.close()
        node.destroy_node()
        try_shutdown()
    return 0


def exit_with(code: int) -> None:
    """End the process at once; DDS threads that outlive Python's own end have nothing to lose."""
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
