"""Disturbances of the simulated robot over ROS: start values, changes while it runs, refusals."""

from __future__ import annotations

import pytest
from rcl_interfaces.srv import GetParameters

from bha_bringup.disturbing import as_parameters
from bha_bringup.robot_client import SIMULATOR
from bha_bringup.robot_connection import RobotError
from bha_sim.disturbances import Disturbances
from running_graph import RunningGraph, StartGraph

pytestmark = pytest.mark.graph


@pytest.fixture
def simulator(start_graph: StartGraph) -> RunningGraph:
    """Start the simulator alone, with 0.1 kg at its tip from the beginning."""
    return start_graph(
        models=(),
        only=[SIMULATOR],
        real_time_factor=20.0,
        parameters={SIMULATOR: {"disturbances.payload": 0.1}},
    )


def told(graph: RunningGraph) -> str:
    return graph.fresh(SIMULATOR)["disturbances"]


def payload(graph: RunningGraph) -> float:
    request = GetParameters.Request(names=["disturbances.payload"])
    answer = graph.client.call(GetParameters, f"{SIMULATOR}/get_parameters", request)
    return float(answer.values[0].double_value)


def test_it_is_disturbed_while_it_runs_and_taken_back(simulator: RunningGraph) -> None:
    """The tip sinks under its load, and comes up again when that is taken off."""
    assert told(simulator) == "payload 0.1"
    simulator.wait_robot(10.0)
    light = simulator.tip()[2]
    simulator.client.set_parameters(
        SIMULATOR,
        as_parameters(Disturbances(payload=0.8, stuck_valves=(True,) + (False,) * 8)),
    )
    simulator.wait(lambda: simulator.tip()[2] > light + 0.004, "the tip sinking")
    assert told(simulator) == "payload 0.8; stuck_valves bellows_1_1"
    simulator.wait_robot(5.0)
    heavy = simulator.tip()[2]
    # A fresh robot has the same load.
    simulator.client.reset()
    assert told(simulator) == "payload 0.8; stuck_valves bellows_1_1"
    simulator.wait(lambda: abs(simulator.tip()[2] - heavy) < 0.004, "the same load")
    simulator.client.set_parameters(SIMULATOR, as_parameters(Disturbances()))
    simulator.wait(lambda: simulator.tip()[2] < heavy - 0.003, "the tip coming up")
    assert told(simulator) == "none"


def test_what_cannot_be_is_refused_with_its_reason_and_changes_nothing(
    simulator: RunningGraph,
) -> None:
    for name, value, reason in (
        ("disturbances.payload", 3.0, "payload"),
        ("disturbances.payload", "heavy", "[Tt]ype"),
        ("disturbances.leak", [0.1, 0.2], "leak must be one value, 3 .* or 9"),
        ("disturbances.softening", [0.9], r"softening holds 0\.9; valid is 0\.0 to 0\.5"),
        ("disturbances.sensor_shift", [float("nan")] * 9, "sensor_shift must hold a finite number"),
        ("robot_seed", 3, "[Rr]ead-?only"),
    ):
        with pytest.raises(RobotError, match=f"simulator: .*{reason}"):
            simulator.client.set_parameters(SIMULATOR, {name: value})
        assert payload(simulator) == 0.1
    assert told(simulator) == "payload 0.1"
