"""When the emulated robot steps, with a clock that the test turns."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import pytest
import rclpy

from bha_bringup.graph import NodeDescription
from bha_bringup.graph_processes import GraphProcesses
from bha_bringup.terminal_emulator_node import EmulatorNode
from bha_common.ros_messages import nanoseconds
from running_graph import PATIENCE, ros_domain

pytestmark = pytest.mark.graph

MS = 1_000_000
TICK = 1_700_000_000_000 * MS  # a whole second


@pytest.fixture
def node() -> Iterator[EmulatorNode]:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with ros_domain():
        rclpy.init(args=["--ros-args", "-p", f"port:={port}"])
        made = EmulatorNode()
        yield made
        made.close()
        made.destroy_node()
        rclpy.try_shutdown()


def test_a_state_is_there_before_its_time_and_once(
    node: EmulatorNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A driver on the same grid reads it at its time, and answers before the next."""
    steps, tips, clock = [], [], SimpleNamespace(now=lambda: clock.time)
    monkeypatch.setattr(node, "_time", clock)
    monkeypatch.setattr(node._emulator, "step", lambda: steps.append(clock.time))
    monkeypatch.setattr(node, "_tip", SimpleNamespace(publish=tips.append))
    clock.time = TICK - 8 * MS
    node.work()
    for time in range(1, 401):  # a millisecond at a time
        clock.time = TICK - 8 * MS + time * MS
        node.work()
    apart = [second - first for first, second in pairwise(steps)]
    assert apart == [20 * MS] * 20
    for moment in steps:
        assert (moment - TICK) % (20 * MS) == 12 * MS, "between the driver's write and its read"
    stamps = [nanoseconds(tip.header.stamp) - TICK for tip in tips]
    assert stamps == [100 * MS * number for number in range(5)]


def test_a_port_in_use_is_told_in_one_line(tmp_path: Path) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        nodes = [NodeDescription("bha_bringup", "terminal_emulator", {"port": port})]
        processes = GraphProcesses(nodes, tmp_path)
        with processes:
            assert processes._processes["terminal_emulator"].wait(PATIENCE) == 2
    log = (tmp_path / "terminal_emulator.log").read_text()
    assert f"error: 127.0.0.1:{port}: cannot listen there; is it in use?" in log
    assert "Traceback" not in log


def test_a_robot_does_not_wait(node: EmulatorNode, monkeypatch: pytest.MonkeyPatch) -> None:
    steps, clock = [], SimpleNamespace(time=TICK, now=lambda: clock.time)
    monkeypatch.setattr(node, "_time", clock)
    monkeypatch.setattr(node._emulator, "step", lambda: steps.append(clock.time))
    node.work()
    clock.time += 100 * MS
    node.work()
    assert len(steps) == 1 + 5, "what was missed is caught up with"
