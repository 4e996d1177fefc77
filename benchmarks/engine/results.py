"""A table from its runs: made, stored, summarised, and written as JSON and as a figure."""

from __future__ import annotations

import dataclasses
import datetime
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from benchmarks.engine import plain_json
from benchmarks.engine.execution import Job, on_a_cluster, on_this_machine
from benchmarks.engine.experiment import Bound, Experiment, Run, Settings, Summary
from benchmarks.engine.provenance import fingerprint, versions
from benchmarks.engine.run_store import RunStore, StoredRun

QUICK_SEEDS = 2


@dataclass(frozen=True)
class Order:
    """How a table is to be made.

    Attributes
    ----------
    seeds : How many seeds; None for the table's own number.
    first_seed : The first of them. 0 to 99 are for tuning, 1000 and up for reporting.
    quick : A minute in all, to see that it works.
    jobs : Runs at once on this machine; -1 for as many as there are cores.
    scheduler : Address of a Dask scheduler to use in place of this machine's cores.
    out : Folder of the results.
    """

    seeds: int | None = None
    first_seed: int = 1000
    quick: bool = False
    jobs: int = -1
    scheduler: str | None = None
    out: Path = Path("results")

    def seeds_of(self, experiment: Experiment) -> list[int]:
        """Return the seeds that a table is made with."""
        own = min(experiment.seeds, QUICK_SEEDS) if self.quick else experiment.seeds
        count = own if self.seeds is None else self.seeds
        return list(range(self.first_seed, self.first_seed + count))

    def command(self, experiment: Experiment) -> str:
        """Return the command that makes this table again."""
        words = [f"./bha paper {experiment.name}"]
        words += ["--quick"] if self.quick else []
        words += [] if self.seeds is None else [f"--seeds {self.seeds}"]
        words += [] if self.first_seed == 1000 else [f"--first-seed {self.first_seed}"]
        return " ".join(words)


@dataclass(frozen=True)
class Result:
    """A table that was made; `content` is its JSON."""

    summary: Summary
    content: dict[str, Any]
    figure: Path

    @property
    def missed(self) -> list[Bound]:
        """Bounds that do not hold; those that quick runs cannot tell are left out."""
        bounds = [bound for bound in self.summary.bounds if not bound.holds]
        if self.content["quick"]:
            return [bound for bound in bounds if bound.measured is not None]
        return bounds


Progress = Callable[[int, int], None]
"""Told after every run: how many are there, of how many."""


def make_table(experiment: Experiment, order: Order, progress: Progress) -> Result:
    """Make the runs that are not there yet, and of all of them the table, its JSON and figure.

    Every run is stored as it ends; what interrupts this costs no more than the runs under way.
    """
    seeds, plan = order.seeds_of(experiment), list(experiment.plan(order.quick))
    stored = _make_runs(experiment, seeds, plan, order, progress)
    runs = [each.run for each in stored]
    summary = experiment.summarise(runs)
    content = {
        "name": experiment.name,
        "claim": experiment.claim,
        "shows": experiment.shows,
        "rows": summary.rows,
        "bounds": [dataclasses.asdict(bound) for bound in summary.bounds],
        "note": summary.note,
        "runs": [
            {
                "seed": each.run.seed,
                "settings": each.run.settings,
                "seconds": each.seconds,
                "figures": each.run.figures,
            }
            for each in stored
        ],
        "settings": plan,
        "seeds": seeds,
        "quick": order.quick,
        "command": order.command(experiment),
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "versions": versions() | {"code": fingerprint(experiment.run.__module__)},
    }
    plain_json.write(order.out / f"{experiment.name}.json", content)
    figure = order.out / f"{experiment.name}.png"
    _draw(experiment, runs, figure)
    return Result(summary, plain_json.round_trip(content), figure)


def _make_runs(
    experiment: Experiment,
    seeds: Sequence[int],
    plan: Sequence[Settings],
    order: Order,
    progress: Progress,
) -> list[StoredRun]:
    """Return all runs in the order of seeds and plan, whenever each of them was made."""
    made_with = fingerprint(experiment.run.__module__)
    store = RunStore(order.out / ".runs" / f"{experiment.name}.jsonl", made_with)
    wanted = [(seed, settings) for seed in seeds for settings in plan]
    jobs = [
        Job(experiment.run, seed, settings, made_with)
        for seed, settings in wanted
        if store.get(seed, settings) is None
    ]
    done = len(wanted) - len(jobs)
    progress(done, len(wanted))
    if jobs:
        made = (
            on_this_machine(jobs, order.jobs)
            if order.scheduler is None
            else on_a_cluster(jobs, order.scheduler)
        )
        for stored in made:
            store.add(stored)
            done += 1
            progress(done, len(wanted))
    found = [store.get(seed, settings) for seed, settings in wanted]
    return [stored for stored in found if stored is not None]


def _draw(experiment: Experiment, runs: Sequence[Run], path: Path) -> None:
    # Without pyplot no display is looked for, and no state is shared with anybody.
    figure = Figure(figsize=(9.0, 5.0), layout="constrained")
    experiment.draw(runs, figure)
    figure.savefig(path, dpi=120)
