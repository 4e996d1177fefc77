"""The demonstration as a user runs it: from nothing to its report."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from bha_common.ros_messages import lengths_from, nanoseconds
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters
from running_graph import PATIENCE, SECOND, ros_domain

pytestmark = [pytest.mark.graph, pytest.mark.slow]

SEED = 3

DEEP_QOS = QoSProfile(depth=200_000)
"""Every length of a minute's demonstration waits for the test, however late it gets to run."""


def run_demo(out: Path, timeout: float = 240.0) -> list[Any]:
    """Run the shortest demonstration; the lengths that its robot told."""
    messages: list[Any] = []
    with ros_domain():
        rclpy.init(args=[])
        try:
            listener = rclpy.create_node("listener")
            listener.create_subscription(JointState, "/bha/lengths", messages.append, DEEP_QOS)
            arguments = ["--minutes", "1", "--quick", "--goals", "1", "--seed", str(SEED)]
            demo = subprocess.Popen(
                [sys.executable, "-m", "bha_bringup.cli", "demo", *arguments, "--out", str(out)],
                env={**os.environ, "XDG_RUNTIME_DIR": str(out)},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
            )
            try:
                deadline = time.monotonic() + timeout
                while demo.poll() is None and time.monotonic() < deadline:
                    rclpy.spin_once(listener, timeout_sec=0.1)
            finally:
                demo.send_signal(signal.SIGINT)  # it ends its nodes
                said, _ = demo.communicate(timeout=PATIENCE)
            assert demo.returncode == 0, said
        finally:
            rclpy.shutdown()
    return messages


def test_it_begins_with_a_fresh_robot_and_ends_with_a_report(tmp_path: Path) -> None:
    messages = run_demo(tmp_path)

    results = json.loads((tmp_path / "results.json").read_text())
    assert results["complete"]
    assert results["samples"] >= 80
    assert results["home_error_m"] < 0.05
    (goal,) = results["goals"]
    assert goal["feedback_error_m"] < 0.01
    assert (tmp_path / "models" / "inverse_model.npz").exists()
    assert (tmp_path / "report.md").exists()

    # The noise of the potentiometers tells which robot it is, and how old it is. The robot that the
    # demonstration has found tells the same lengths, but each at its own time since the start.
    plant = Plant(draw_robot(load_parameters(), SEED), seed=SEED)
    period = round(SECOND * plant.control_period)
    fresh = [plant.state.lengths] + [plant.step(np.zeros(9)).lengths for _ in range(9)]
    found = {(tick + 1) * period: lengths.tobytes() for tick, lengths in enumerate(fresh)}
    begun_anew = {
        told
        for message in messages
        if (told := lengths_from(message).tobytes()) in found.values()
        and told != found.get(nanoseconds(message.header.stamp))
    }
    assert len(begun_anew) >= 3
