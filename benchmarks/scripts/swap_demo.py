"""The proof of the swap: the same demonstration in the simulator and behind driver and terminal.

./bha shell python -m benchmarks.scripts.swap_demo --seeds 0 1 2 --minutes 5

For each robot the whole of `./bha demo` runs twice, one run after the other and each from nothing:
in the simulator in lockstep, and behind the emulated terminal in real time. Seeds of robot,
identification, exploration and goals, samples, minutes and goals are the same. Printed are mean and
median errors over the held-out goals, feed-forward and with feedback, and whether the means behind
the terminal are within the bound of those in the simulator.

What is learned in a few minutes differs by chance, though: a run that begins a second later gives
other errors, in the simulator alone (benchmarks.scripts.swap_spread). So `--spread` more runs in
the simulator, in one process, tell where the run behind the terminal lies among its like.

A run behind the terminal takes its time: 5 minutes of exploration and 30 goals take about half an
hour, and want calm cores: the log of terminal_emulator in the run's folder ends with how many of
its cycles were late. `--resume` goes on after those that are done; `--dry-run` tells the plan.
"""

import argparse
import json
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from benchmarks.scripts import swap_spread
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
    simulated, emulated : Errors [m], shape (goals,) each.
    """

    simulated: NDArray[np.float64]
    emulated: NDArray[np.float64]

    @property
    def difference(self) -> float:
        """Mean error behind the terminal over that in the simulator, less 1."""
        return float(self.emulated.mean() / self.simulated.mean() - 1.0)

    @property
    def standard_error(self) -> float:
        """Standard error of the difference from the choice of the goals alone, to first order."""
        ratio = self.emulated.mean() / self.simulated.mean()
        residual = (self.emulated - ratio * self.simulated) / self.simulated.mean()
        return float(residual.std(ddof=1) / np.sqrt(residual.size))

    @property
    def holds(self) -> bool:
        """Whether the difference is within the bound."""
        return abs(self.difference) <= BOUND

    def __str__(self) -> str:
        def both(errors: NDArray[np.float64]) -> str:
            return f"{errors.mean() * 1e3:6.1f} {np.median(errors) * 1e3:6.1f}"

        return (
            f"{both(self.simulated)}   {both(self.emulated)}   "
            f"{self.difference:+5.0%} +- {self.standard_error:.0%}  "
            f"{'holds' if self.holds else 'MISSED'}"
        )


def plan(seeds: list[int], minutes: float, goals: int, out: Path) -> list[DemoSettings]:
    """Give the demonstrations in their order; two of a seed differ by the robot alone."""
    return [
        DemoSettings(
            minutes=minutes, seed=seed, goals=goals, robot=robot, out=out / f"{robot}_seed{seed}"
        )
        for seed in seeds
        for robot in (SIM, EMULATED)
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


def place(settings: DemoSettings, mean: float, runs: int) -> str:
    """Tell where a mean error [m] lies among runs in the simulator that begin seconds later."""
    seed, minutes, goals = settings.seed, settings.minutes, settings.goals
    others = np.array(
        [
            swap_spread.error(
                seed, seed, minutes, goals, settings.identification_samples, float(late)
            )
            for late in range(1, 1 + runs)
        ]
    )
    low, high = others.min() * 1e3, others.max() * 1e3
    return (
        f"{mean * 1e3:.1f} mm behind the terminal; {runs} runs in the simulator {low:.1f} to "
        f"{high:.1f} mm, mean {others.mean() * 1e3:.1f} mm: {mean / others.mean() - 1.0:+.0%}; "
        f"{int((others < mean).sum())} of them are better"
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
    parser.add_argument("--spread", type=int, default=8, help="more runs in the simulator; or 0")
    parser.add_argument("--resume", action="store_true", help="take over runs that are done")
    parser.add_argument("--dry-run", action="store_true", help="tell the plan, run nothing")
    arguments = parser.parse_args()
    console = Console(highlight=False)
    errors: dict[tuple[int, str], dict[str, NDArray[np.float64]]] = {}
    for settings in plan(arguments.seeds, arguments.minutes, arguments.goals, arguments.out):
        found = stored(settings) if arguments.resume else None
        state = "done" if found else "to run"
        console.print(f"robot {settings.seed}, {settings.robot}: {state}, {settings.out}")
        if not arguments.dry_run:
            errors[settings.seed, settings.robot] = found or measure(settings, console)
    if arguments.dry_run:
        return
    for settings in plan(arguments.seeds, arguments.minutes, arguments.goals, arguments.out):
        print(f"robot {settings.seed}, {settings.robot}: {counts(settings)}")
    print("mean and median error over the goals [mm]")
    print(f"{'robot':6s} {'':14s} {'simulator':>13s}   {'terminal':>13s}   means differ by")
    missed = 0
    for seed in arguments.seeds:
        for kind, words in KINDS.items():
            one = Comparison(errors[seed, SIM][kind], errors[seed, EMULATED][kind])
            missed += not one.holds
            print(f"{seed:<6d} {words:14s} {one}")
    print(f"within {BOUND:.0%}: {'all' if not missed else f'{missed} are not'}")
    if arguments.spread:
        for settings in plan(arguments.seeds, arguments.minutes, arguments.goals, arguments.out):
            if settings.robot == EMULATED:
                mean = float(errors[settings.seed, EMULATED]["feedforward"].mean())
                where = place(settings, mean, arguments.spread)
                print(f"robot {settings.seed}, feed-forward: {where}", flush=True)
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
