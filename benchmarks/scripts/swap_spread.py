"""How much five minutes of learning differ by chance, on one and the same simulated robot.

./bha shell python -m benchmarks.scripts.swap_spread --repeats 5

The robot of each seed is identified, explores and reaches held-out goals as in `./bha demo`,
feed-forward, once with the seed's own draws and then with others for postures, exploration, noise
and drift of the sensors. With `--late 1` all runs have the seed's own draws, and each begins a
second of robot time later than the one before. That is what runs of benchmarks.scripts.swap_demo
differ by, so it is the scale on which a driver between the two can be judged. With `--late 60` the
sensors have drifted elsewhere from one run to the next.
"""

import argparse

import numpy as np

from bha_bringup.in_process import InProcessRobot
from bha_goal_babbling.learner_settings import LearnerSettings
from bha_goal_babbling.task import find_task
from bha_pressure_ctrl.pressure_control import PressureControlSettings


def error(
    seed: int, draws: int, minutes: float, goals: int, samples: int, late: float = 0.0
) -> float:
    """Mean feed-forward error over held-out goals [m], of a run that begins `late` [s]."""
    task = find_task("2d")
    robot = InProcessRobot(
        task,
        seed=seed,
        learner_settings=LearnerSettings(seed=draws),
        control_settings=PressureControlSettings(seed=draws),
    )
    robot.plant.reset(draws)
    robot.run_until(lambda: False, late)
    robot.identify(samples)
    robot.babble(minutes * 60.0)
    positions = task.held_out_positions(goals, np.random.default_rng([seed, 1]))
    return float(np.mean([robot.reach(position).error for position in positions]))


def main() -> None:
    """Print one line a robot."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=3, help="seeds 0, 1, ...")
    parser.add_argument("--repeats", type=int, default=5, help="runs a robot")
    parser.add_argument("--minutes", type=float, default=5.0, help="robot minutes of exploration")
    parser.add_argument("--goals", type=int, default=10, help="held-out goals")
    parser.add_argument("--samples", type=int, default=40, help="postures of the identification")
    parser.add_argument("--late", type=float, help="keep the draws, begin ever later by this [s]")
    arguments = parser.parse_args()
    for seed in range(arguments.robots):
        runs = [
            (seed if arguments.late or not run else 999 + run, run * (arguments.late or 0.0))
            for run in range(arguments.repeats)
        ]
        errors = [
            error(seed, draws, arguments.minutes, arguments.goals, arguments.samples, late) * 1e3
            for draws, late in runs
        ]
        mean, spread = np.mean(errors), np.std(errors, ddof=1)
        print(
            f"robot {seed}: {' '.join(f'{value:.1f}' for value in errors)} mm; mean {mean:.1f}, "
            f"standard deviation {spread:.1f} mm ({spread / mean:.0%})",
            flush=True,
        )


if __name__ == "__main__":
    main()
