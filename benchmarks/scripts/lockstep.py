"""The speed of the graph: four processes in lockstep, babbling.

./bha shell python -m benchmarks.scripts.lockstep --minutes 10

Prints how many times faster than real time the robot runs, and what a control period (a tick)
costs each process, so that it shows where the time goes.
"""

import argparse
import os
import tempfile
import time
from pathlib import Path

from bha_bringup.graph import GraphSettings, describe_graph
from bha_bringup.graph_processes import GraphProcesses
from bha_bringup.in_process import InProcessRobot
from bha_bringup.robot_client import RobotClient
from bha_goal_babbling.task import find_task
from bha_pressure_ctrl.pressure_control import PressureControlSettings

_WARM_UP = 30.0  # [s] of robot time until everything is compiled and discovered


def main() -> None:
    """Print one line for each of some equal parts of the babbling."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--space", default="2d", help="2d, 3d, or the path of a task file")
    parser.add_argument("--minutes", type=float, default=10.0, help="robot minutes of babbling")
    parser.add_argument("--parts", type=int, default=5, help="how many lines are printed")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        measure(
            arguments.space, arguments.minutes * 60.0 / arguments.parts, arguments.parts, folder
        )


def measure(space: str, duration: float, parts: int, folder: str) -> None:
    """Babble `parts` times for `duration` [s] and print the speed of each."""
    model = InProcessRobot(find_task(space)).identify()
    model.save(Path(folder, "equilibrium_model.npz"), "bha_sim_0")
    settings = GraphSettings(space=space, real_time_factor=0.0, models=Path(folder))
    nodes = describe_graph(settings)
    names = [node.executable for node in nodes]
    with GraphProcesses(nodes, Path(folder)) as processes, RobotClient(processes.check) as client:
        client.wait_for_graph(set(names))
        client.babble(_WARM_UP)
        ticks = duration / PressureControlSettings().control_period
        print("times real time  tick [us]  processor time of a tick [us]: " + ", ".join(names))
        for _ in range(parts):
            before, start = [_processor_time(processes.pid(name)) for name in names], time.time()
            client.babble(duration)
            wall = time.time() - start
            after = [_processor_time(processes.pid(name)) for name in names]
            used = (f"{(b - a) / ticks * 1e6:.0f}" for a, b in zip(before, after, strict=True))
            print(f"{duration / wall:15.1f}  {wall / ticks * 1e6:9.0f}  " + ", ".join(used))


def _processor_time(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
