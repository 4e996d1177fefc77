"""From reading the lengths to writing the pressures, in the whole graph behind the terminal.

./bha shell python -m benchmarks.scripts.driver_latency

Starts the graph of `./bha demo --robot hardware-emulated` in real time and watches, seen from the
terminal, how each cycle lies between the steps of the robot: in the simulator every state is
answered before the next step, so states that are read twice or not at all, and writes that come
after the next step, are what the two differ by.
"""

import argparse
import tempfile
from pathlib import Path

from bha_bringup.graph import EMULATED, GraphSettings, describe_graph
from bha_bringup.graph_processes import GraphProcesses
from bha_bringup.robot_client import RobotClient

VALUES = ("cycles", "states read twice", "states not read", "late writes")


def watch(seconds: float) -> tuple[dict[str, int], str]:
    """Let the graph run [s]; counts of that time, and the times from read to write."""
    nodes = describe_graph(GraphSettings(robot=EMULATED))
    with (
        tempfile.TemporaryDirectory() as folder,
        GraphProcesses(nodes, Path(folder)) as processes,
        RobotClient(processes.check) as robot,
    ):
        robot.wait_for_graph({node.executable for node in nodes})

        def said(after: float) -> dict[str, str]:
            robot.diagnostics.pop("terminal_emulator", None)
            robot.wait(lambda: False, after)
            robot.wait(lambda: "terminal_emulator" in robot.diagnostics, 10.0)
            values = robot.diagnostics["terminal_emulator"].values
            return {item.key: item.value for item in values}

        before = said(3.0)
        after = said(seconds)
    counts = {name: int(after[name]) - int(before[name]) for name in VALUES}
    return counts, after["read to write [ms]"]


def main() -> None:
    """Print what was seen."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=60.0, help="how long it is watched")
    arguments = parser.parse_args()
    counts, times = watch(arguments.seconds)
    print(f"read to write, median: {times} ms")
    for name, count in counts.items():
        print(f"{name:18s} {count:6d}  {count / max(counts['cycles'], 1):.2%}")


if __name__ == "__main__":
    main()
