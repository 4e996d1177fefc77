"""Learning on the simulated BHA without ROS: errors over exploration time, and times real time.

./bha shell python -m benchmarks.scripts.in_process --space 2d --seeds 0 1 2 --minutes 30 60
"""

import argparse
import time

import numpy as np

from bha_bringup.in_process import InProcessRobot
from bha_goal_babbling.task import find_task


def main() -> None:
    """Print one line for each robot and exploration time."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--space", default="2d", help="2d, 3d, or the path of a task file")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2], help="robots")
    parser.add_argument("--minutes", type=float, nargs="+", default=[30.0], help="exploration")
    parser.add_argument("--goals", type=int, default=25, help="held-out goals")
    arguments = parser.parse_args()
    print("robot  minutes  movements  maps  mean [mm]  median [mm]  95 % [mm]  times real time")
    for seed in arguments.seeds:
        measure(arguments.space, seed, sorted(arguments.minutes), arguments.goals)


def measure(space: str, seed: int, minutes: list[float], goals: int) -> None:
    """Identify, babble and reach on one robot, and print what came of it."""
    task = find_task(space)
    robot = InProcessRobot(task, seed=seed)
    robot.identify()
    positions = task.held_out_positions(goals, np.random.default_rng([seed, 1]))
    explored = 0.0
    for target in minutes:
        start, processor = robot.time, time.process_time()
        robot.babble((target - explored) * 60.0)
        factor = (robot.time - start) / (time.process_time() - processor)
        explored = target
        errors = 1e3 * np.array([robot.reach(position).error for position in positions])
        babbler = robot.learner.babbler
        assert babbler is not None
        print(
            f"{seed:5d}  {target:7.0f}  {babbler.movements:9d}  {babbler.local_maps:4d}  "
            f"{errors.mean():9.1f}  {np.median(errors):11.1f}  {np.percentile(errors, 95):9.1f}  "
            f"{factor:15.0f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
