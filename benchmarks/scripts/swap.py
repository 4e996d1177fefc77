"""The same models on the same goals: in the simulator, and behind driver and terminal.

./bha shell python -m benchmarks.scripts.swap results/demo_2d_seed0/models --seed 0

What is learned in a few minutes differs by chance (benchmarks.scripts.swap_spread). Here nothing is
learned: models of one robot reach held-out goals, feed-forward, once in lockstep and once in real
time through Modbus, so that what is left is the driver, the terminal, time, and the robot's noise.
"""

import argparse
import shutil
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bha_bringup.graph import EMULATED, SIM, GraphSettings, describe_graph
from bha_bringup.graph_processes import GraphProcesses
from bha_bringup.model_transfer import FILES
from bha_bringup.robot_client import RobotClient
from bha_goal_babbling.task import find_task


def errors(robot: str, models: Path, seed: int, goals: int) -> NDArray[np.float64]:
    """Reach held-out goals with given models; the errors [m], shape (goals,)."""
    task = find_task("2d")
    positions = task.held_out_positions(goals, np.random.default_rng([seed, 1]))
    with tempfile.TemporaryDirectory() as folder:
        for name in FILES:
            shutil.copy(models / name, folder)
        settings = GraphSettings(
            robot=robot,
            seed=seed,
            models=Path(folder),
            real_time_factor=0.0 if robot == SIM else 1.0,
        )
        nodes = describe_graph(settings)
        with GraphProcesses(nodes, Path(folder)) as processes, RobotClient(processes.check) as bha:
            bha.wait_for_graph({node.executable for node in nodes})
            bha.reach(np.array([0.0, 0.0, 0.78]))  # away from where it hung
            return np.array([bha.reach(position).error for position in positions])


def main() -> None:
    """Print the errors of both, goal by goal, and their means."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("models", type=Path, help="folder with the models of the simulated robot")
    parser.add_argument("--seed", type=int, default=0, help="which robot they belong to")
    parser.add_argument("--goals", type=int, default=10, help="held-out goals")
    arguments = parser.parse_args()
    found = {}
    for robot in (SIM, EMULATED):
        found[robot] = errors(robot, arguments.models, arguments.seed, arguments.goals) * 1e3
        each = " ".join(f"{value:.1f}" for value in found[robot])
        print(f"{robot:18s} mean {found[robot].mean():.1f} mm: {each}", flush=True)
    ratio = found[EMULATED].mean() / found[SIM].mean() - 1.0
    print(f"behind the terminal {ratio:+.0%}")


if __name__ == "__main__":
    main()
