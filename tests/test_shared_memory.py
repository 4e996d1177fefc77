"""What the nodes hold of the middleware's shared memory, and that they give it back."""

from __future__ import annotations

from pathlib import Path

import pytest
from rclpy.utilities import get_rmw_implementation_identifier

from running_graph import StartGraph

pytestmark = pytest.mark.graph


def segments(pid: int) -> set[Path]:
    """What a process uses that belongs to one participant of Fast DDS: it or one it talks to."""
    maps = Path(f"/proc/{pid}/maps").read_text().splitlines()
    paths = {Path(line.split(maxsplit=5)[5]) for line in maps if "/dev/shm/fastrtps_" in line}
    return {path for path in paths if "port" not in path.name}


@pytest.mark.skipif(
    get_rmw_implementation_identifier() != "rmw_fastrtps_cpp",
    reason="other middleware names its shared memory otherwise",
)
def test_nodes_that_end_give_back_their_shared_memory(start_graph: StartGraph) -> None:
    graph = start_graph()
    held = set[Path]().union(*(segments(graph.processes.pid(name)) for name in graph.names))
    assert held
    graph.close()
    assert not [str(path) for path in held if path.exists()]
