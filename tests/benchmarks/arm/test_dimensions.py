"""The table `dimensions`: its runs, its rows, and that its bounds come of runs."""

from typing import Any

from matplotlib.figure import Figure

from benchmarks.arm.dimensions import CONFIGS, EXPERIMENT, FAST, JOINTS, RLS
from benchmarks.engine.experiment import Bound, Run


def made(seeds: int = 4, **changes: dict[tuple[str, int], Any]) -> list[Run]:
    """Return invented runs: 10 movements, 50 samples each, unless `needed` says otherwise."""
    needed = changes.get("needed", {})
    runs = []
    for method in CONFIGS:
        for joints in JOINTS:
            for seed in range(seeds):
                movements = needed.get((method, joints), [10.0])
                value = movements[seed % len(movements)]
                samples = None if value is None else 5 * value
                figures = {"movements": value, "samples": samples}
                runs.append(Run(seed, {"method": method, "joints": joints}, figures))
    return runs


def bound(runs: list[Run], *words: str) -> Bound:
    """Return the one bound in whose text all words stand."""
    found = [b for b in EXPERIMENT.summarise(runs).bounds if all(word in b.what for word in words)]
    assert len(found) == 1
    return found[0]


def test_quick_runs_make_a_table_and_a_figure() -> None:
    """Both methods get there, RLS in fewer samples."""
    settings = EXPERIMENT.plan(True)
    runs = [Run(0, chosen, EXPERIMENT.run(0, **chosen)) for chosen in settings]
    summary = EXPERIMENT.summarise(runs)
    assert len(summary.rows) == len(settings)
    samples = {(row["method"], row["joints"]): row["samples, median"] for row in summary.rows}
    assert all(samples[RLS, joints] < samples[FAST, joints] for joints in (2, 5))
    assert bound(runs, "of 100").measured == 0.0
    assert bound(runs, FAST, "2 to 50").measured is None  # not all arms were tried
    figure = Figure()
    EXPERIMENT.draw(runs, figure)
    assert len(figure.axes[0].get_legend().get_texts()) == 3


def test_the_whole_plan_has_every_method_on_every_arm() -> None:
    plan = EXPERIMENT.plan(False)
    assert len(plan) == len(CONFIGS) * len(JOINTS)
    assert {(run["method"], run["joints"]) for run in plan} == {
        (method, joints) for method in CONFIGS for joints in JOINTS
    }


def test_bounds_are_the_largest_medians() -> None:
    runs = made(needed={(RLS, 20): [20.0, 30.0], (RLS, 200): [61.0], (FAST, 3): [70.0]})
    assert bound(runs, RLS, "movements", "2 to 50").measured == 25.0
    assert bound(runs, RLS, "movements", "2 to 50").holds
    assert bound(runs, RLS, "samples").measured == 125.0
    assert not bound(runs, RLS, "samples").holds
    assert not bound(runs, RLS, "100 and 200").holds
    assert bound(runs, FAST, "2 to 50").measured == 70.0
    assert not bound(runs, FAST, "2 to 50").holds


def test_runs_that_did_not_get_there_count_as_endless() -> None:
    """One of four moves no median; two of four leave none."""
    rare = made(needed={(RLS, 10): [None, 10.0, 10.0, 10.0]})
    assert bound(rare, RLS, "movements", "2 to 50").measured == 10.0
    share = 100 / len(JOINTS) / 4
    assert abs((bound(rare, "of 100").measured or 0.0) - share) < 1e-9
    assert not bound(rare, "of 100").holds
    row = next(
        row
        for row in EXPERIMENT.summarise(rare).rows
        if (row["method"], row["joints"]) == (RLS, 10)
    )
    assert row["not there"] == "1 of 4"
    often = made(needed={(RLS, 10): [None, 10.0]})
    assert bound(often, RLS, "movements", "2 to 50").measured is None
    assert not bound(often, RLS, "movements", "2 to 50").holds
