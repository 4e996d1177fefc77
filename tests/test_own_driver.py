"""The driver that docs/your_robot.md shows to those with other hardware."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy

from bha_common.ros_wire import encode_pressures
from running_graph import ros_domain

pytestmark = pytest.mark.graph

PAGE = Path(__file__).parents[1] / "docs" / "your_robot.md"


class Hardware:
    """Keeps what is written to it."""

    def __init__(self) -> None:
        self.written: list[np.ndarray] = []

    def write(self, pressures: np.ndarray) -> None:
        self.written.append(pressures.copy())

    def read(self) -> tuple[np.ndarray, np.ndarray]:
        return np.full(9, 0.2), self.written[-1]


def test_it_takes_commands_and_stops() -> None:
    text = PAGE.read_text(encoding="utf-8")
    block = next(b for b in re.findall(r"```python\n(.*?)```", text, re.S) if "LabDriver" in b)
    scope: dict[str, Any] = {}
    exec(inspect.cleandoc(block), scope)
    hardware = Hardware()
    with ros_domain():
        rclpy.init()
        node = scope["LabDriver"](hardware)
        try:

            def cycle() -> float:
                node.due = 0.0
                node.work()
                return float(hardware.written[-1].max())

            assert cycle() == 0.0
            (stream,) = node._streams._subscriptions
            stream.callback(encode_pressures(node.now, np.full(9, 1e4)))
            assert cycle() == 1e4
            scope["LabDriver"].stop(node, None, scope["Trigger"].Response())
            assert cycle() < 1e4
            stream.callback(encode_pressures(node.now, np.full(9, 1e4)))
            assert cycle() < 1e4
            assert node._intakes[0].dropped == 0
        finally:
            node.destroy_node()
            rclpy.try_shutdown()
