"""The proof of the swap: the same demonstrations in the simulator and behind driver and terminal.

./bha shell python -m benchmarks.scripts.swap_demo --seeds 0 1 2 --minutes 5

For each robot the whole of `./bha demo` runs in the simulator in lockstep, and behind the emulated
terminal in real time, one run after the other and each from nothing. Seeds of robot,
identification, exploration and goals, samples, minutes and goals are the same. Printed are the mean
errors of the runs over the held-out goals, feed-forward and with feedback, and whether their mean
behind the terminal is within the bound of that in the simulator.

What is learned in a few minutes differs by chance: a run that begins a second later gives other
errors, in the simulator alone (benchmarks.scripts.swap_spread). So each runs several times, the
simulator more often, where a run takes a minute; the standard error of the difference is told.

A run behind the terminal takes its time: 5 minutes of exploration and 30 goals take about half an
hour, and want calm cores: the log of terminal_emulator in the run's folder ends with how many of
its cycles were late. Robots may run side by side, each in its own ROS_DOMAIN_ID. `--resume` goes on
after those that are done; `--dry-run` tells the plan.
"""

import argparse
import json
import sys
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from bha_bringup.demo import run_demo
from bha_bringup.demo_record import DemoRecord
from bha_bringup.demo_settings import DemoSettings
from bha_bringup.graph import EMULATED, SIM

BOUND = 0.2
"""Largest relative difference of the mean errors that is called the same."""

KINDS = {"feedforward": "feed-forward", "feedback": "with feedback"}


@dataclass(frozen=True, eq=False)
class Comparison:
    """Errors of one robot over the same goals, in the simulator and behind the terminal.

    Attributes
    ----------
    simulated, emulated : Errors [m], shape (runs, goals); the number of runs may differ.
    """

    simulated: NDArray[np.float64]
    emulated: NDArray[np.float64]

    @property
    def difference(self) -> float:
        """Mean error behind the terminal over that in the simulator, less 1."""
        return float(self.emulated.mean() / self.simulated.mean() - 1.0)

    @property
    def standard_error(self) -> float:
        """Standard error of the difference from chance between runs, to first order; NaN of one."""
        if min(len(self.simulated), len(self.emulated)) < 2:
            return float("nan")

        def relative(errors: NDArray[np.float64]) -> float:
            means = errors.mean(axis=1)
            return float(means.std(ddof=1) / means.mean() / np.sqrt(len(means)))

        return (1.0 + self.difference) * np.hypot(relative(self.simulated), relative(self.emulated))

    @property
    def holds(self) -> bool:
        """Whether the difference is within the bound."""
        return abs(self.difference) <= BOUND

    def __str__(self) -> str:
        def told(errors: NDArray[np.float64]) -> str:
            runs = " ".join(f"{run.mean() * 1e3:.1f}" for run in errors)
            return f"{errors.mean() * 1e3:.1f} ({runs})"

        return (
            f"simulator {told(self.simulated)}, terminal {told(self.emulated)}: "
            f"{self.difference:+.0%} +- {self.standard_error:.0%}  "
            f"{'holds' if self.holds else 'MISSED'}"
        )


def plan(
    seeds: list[int], minutes: float, goals: int, out: Path, repeats: dict[str, int]
) -> list[DemoSettings]:
    """Give the demonstrations in their order; those of a seed differ by the robot alone."""
    return [
        DemoSettings(
            minutes=minutes,
            seed=seed,
            goals=goals,
            robot=robot,
            out=out / f"{robot}_seed{seed}_run{run}",
        )
        for seed in seeds
        for robot, runs in repeats.items()
        for run in range(runs)
    ]


def stored(settings: DemoSettings) -> dict[str, NDArray[np.float64]] | None:
    """Errors of a demonstration that is done, by kind [m]; None when there is none like it."""
    try:
        data = json.loads((settings.out / "results.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    same = (
        data["complete"]
        and (data["robot"], data["seed"], data["space"])
        == (settings.robot, settings.seed, settings.space)
        and len(data["goals"]) == settings.goals
        and abs(data["exploration_minutes"] - settings.minutes) < 0.05
    )
    if not same:
        return None
    return {kind: np.array([goal[f"{kind}_error_m"] for goal in data["goals"]]) for kind in KINDS}


def measure(settings: DemoSettings, console: Console) -> dict[str, NDArray[np.float64]]:
    """Run a demonstration; its errors by kind [m]."""
    record = DemoRecord(settings)
    run_demo(record, console)
    return {kind: record.errors(kind) for kind in KINDS}


def counts(settings: DemoSettings) -> str:
    """Tell what a demonstration that is done has gathered: both of a seed must have had as much."""
    data = json.loads((settings.out / "results.json").read_text(encoding="utf-8"))
    return (
        f"{data['movements']} movements, {data['samples']} samples, {data['local_models']} maps, "
        f"pressures fit to {(data['pressure_error_pa'] or np.nan) / 1e3:.1f} kPa"
    )


def main() -> None:
    """Print one line a robot and kind, and end with 1 where the bound does not hold."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2], help="which robots")
    parser.add_argument("--minutes", type=float, default=5.0, help="robot minutes of exploration")
    parser.add_argument("--goals", type=int, default=30, help="held-out goals of each run")
    parser.add_argument("--out", type=Path, default=Path("results/swap_demo"), help="folder")
    parser.add_argument("--simulated", type=int, default=9, help="runs of a robot, simulator")
    parser.add_argument("--emulated", type=int, default=3, help="runs of a robot, terminal")
    parser.add_argument("--resume", action="store_true", help="take over runs that are done")
    parser.add_argument("--dry-run", action="store_true", help="tell the plan, run nothing")
    arguments = parser.parse_args()
    if min(arguments.simulated, arguments.emulated) < 1:
        parser.error("--simulated and --emulated must be at least 1")
    console = Console(highlight=False)
    planned = plan(
        arguments.seeds,
        arguments.minutes,
        arguments.goals,
        arguments.out,
        {SIM: arguments.simulated, EMULATED: arguments.emulated},
    )
    runs: dict[tuple[int, str, str], list[NDArray[np.float64]]] = defaultdict(list)
    for settings in planned:
        found = stored(settings) if arguments.resume else None
        state = "done" if found else "to run"
        console.print(f"robot {settings.seed}, {settings.robot}: {state}, {settings.out}")
        if not arguments.dry_run:
            for kind, errors in (found or measure(settings, console)).items():
                runs[settings.seed, settings.robot, kind].append(errors)
    if arguments.dry_run:
        return
    for settings in planned:
        print(f"robot {settings.seed}, {settings.robot}: {counts(settings)}")
    print("mean errors over the goals, of all runs and of each [mm], and how far the means differ")
    missed = 0
    for seed in arguments.seeds:
        for kind, words in KINDS.items():
            one = Comparison(*(np.array(runs[seed, robot, kind]) for robot in (SIM, EMULATED)))
            missed += not one.holds
            print(f"robot {seed}, {words}: {one}")
    print(f"within {BOUND:.0%}: {'all' if not missed else f'{missed} are not'}")
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
