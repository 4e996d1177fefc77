"""The contract "a core knows no ROS" finds what breaks it."""

import pytest
from grimp import ImportGraph

from tools.import_contracts import RosRoomsContract

OPTIONS = {
    "name": "A core knows no ROS",
    "ros_modules": ["rclpy", r"\w+_msgs", r"bha_common\.ros_\w+", r"(\w+\.)+\w+_node"],
    "rooms": [r"bha_common\.ros_\w+", r"(\w+\.)+\w+_node"],
}


def violations(importer: str, imported: str) -> list[tuple[str, str, int]]:
    graph = ImportGraph()
    graph.add_module("rclpy", is_squashed=True)
    graph.add_module("sensor_msgs", is_squashed=True)
    graph.add_import(
        importer=importer, imported=imported, line_number=7, line_contents=f"import {imported}"
    )
    contract = RosRoomsContract(
        name="A core knows no ROS", session_options={}, contract_options=OPTIONS
    )
    check = contract.check(graph, verbose=False)
    found: list[tuple[str, str, int]] = check.metadata["violations"]
    assert check.kept == (not found)
    return found


@pytest.mark.parametrize(
    "imported", ["rclpy", "sensor_msgs", "bha_common.ros_messages", "bha_sim.simulator_node"]
)
def test_a_core_may_not_import_ros(imported: str) -> None:
    assert violations("bha_sim.plant", imported) == [("bha_sim.plant", imported, 7)]


@pytest.mark.parametrize("importer", ["bha_sim.simulator_node", "bha_common.ros_node"])
def test_its_rooms_may(importer: str) -> None:
    assert violations(importer, "rclpy") == []


def test_cores_may_import_cores() -> None:
    assert violations("bha_sim.plant", "bha_common.bellows") == []
