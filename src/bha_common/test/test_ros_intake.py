"""The gate for messages: bad ones are dropped, counted and named."""

from typing import Any

import pytest

pytest.importorskip("rclpy", reason="needs ROS 2")
pytest.importorskip("bha_interfaces.msg", reason="needs the workspace's interfaces")

from bha_common.ros_intake import Intake
from bha_common.ros_messages import MessageError
from bha_common.stamps import StampError


class Logger:
    """Stands in for a node and keeps what it logs."""

    def __init__(self) -> None:
        self.lines: list[tuple[str, dict[str, Any]]] = []

    def get_logger(self) -> "Logger":
        return self

    def warning(self, text: str, **options: Any) -> None:
        self.lines.append((text, options))


def make() -> tuple[Intake, Logger, list[Any]]:
    """Return an intake that takes positive numbers, its log, and what came through."""
    node, taken = Logger(), []

    def take(message: int) -> None:
        if message == 0:
            raise StampError("no stamp")
        if message < 0:
            raise MessageError(f"{message} is below 0")
        taken.append(message)

    return Intake(node, "lengths", take), node, taken


def test_passes_good_messages_on() -> None:
    intake, node, taken = make()
    for message in (1, 2, 3):
        intake(message)
    assert taken == [1, 2, 3]
    assert intake.dropped == 0
    assert intake.values() == {"lengths dropped": "0"}
    assert node.lines == []


def test_drops_counts_and_names_bad_ones() -> None:
    intake, node, taken = make()
    for message in (1, -5, 0, 2, -7):
        intake(message)
    assert taken == [1, 2]
    assert intake.dropped == 3
    assert intake.values() == {"lengths dropped": "3", "lengths last reason": "-7 is below 0"}
    assert "dropped a message on lengths: no stamp (2 so far)" in node.lines[1][0]


def test_logs_once_a_second_at_most() -> None:
    intake, node, _ = make()
    intake(-1)
    assert node.lines[0][1] == {"throttle_duration_sec": 1.0}


def test_other_errors_are_not_hidden() -> None:
    """A mistake in the program must not look like a bad message."""

    def fail(_: Any) -> None:
        raise ValueError("a mistake")

    intake = Intake(Logger(), "lengths", fail)
    with pytest.raises(ValueError, match="a mistake"):
        intake(1)
    assert intake.dropped == 0
