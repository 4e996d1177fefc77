"""The tables unfold, learning-rate and workspace: quick runs, and what is behind their bounds."""

import json
from types import ModuleType

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.arm import learning_rate, unfold, workspace
from benchmarks.engine.experiment import Run


@pytest.mark.parametrize("table", [unfold, learning_rate, workspace])
def test_quick_runs_make_a_table(table: ModuleType) -> None:
    """Rows, bounds and the figure come of the quick plan, and JSON can hold all figures."""
    experiment = table.EXPERIMENT
    plan = [settings for settings in experiment.plan(True) if "RLS" not in str(settings)]
    runs = [Run(0, settings, experiment.run(0, **settings)) for settings in plan]
    json.dumps([made.figures for made in runs])
    summary = experiment.summarise(runs)
    assert len(summary.rows) >= len(plan)
    assert all(row.keys() == summary.rows[0].keys() for row in summary.rows)
    # Quick runs do not go as far as some bounds ask: these are not known, and do not hold.
    assert all(bound.measured is not None or not bound.holds for bound in summary.bounds)
    figure = Figure()
    experiment.draw(runs, figure)
    assert figure.axes[0].lines
    assert experiment.run(0, **plan[0]) == runs[0].figures


def test_unfold_takes_the_best_method() -> None:
    """Its bounds are those of the method with the smallest median over the seeds."""
    runs = []
    for method, error in (("goal babbling", 0.02), ("goal babbling, fast settings", 0.004)):
        for seed in range(3):
            values = [error * (1 + seed)] * 2
            names = ("mean", "median", "worst", "roughness")
            figures = dict.fromkeys(names, values)
            runs.append(Run(seed, {"method": method, "movements": [100, 10_000]}, figures))
    bounds = unfold.summarise(runs).bounds
    assert [bound.measured for bound in bounds] == pytest.approx([8.0, 8.0, 8.0])
    assert [bound.holds for bound in bounds] == [True, False, False]


def test_roughness() -> None:
    """An arm that bends evenly has none, wherever its first joint points."""
    even = np.array([[1.0, 0.1, 0.1, 0.1], [-1.0, 0.0, 0.0, 0.0]])
    assert unfold.roughness(even) == 0.0
    assert unfold.roughness(np.array([[0.0, 0.1, -0.1, 0.1]])) == pytest.approx(0.2)


def test_learning_rate_counts_failures() -> None:
    """A run that never got there counts as infinitely long, and as a failure."""
    runs = [
        Run(
            seed,
            {"joints": joints, "learning_rate": rate, "most_movements": 9},
            {"movements": movements},
        )
        for joints in (2, 10, 50)
        for rate, made in ((0.01, [900, 3000, None]), (0.1, [90, 100, 110]), (1.0, [20, 20, 20]))
        for seed, movements in enumerate(made)
    ]
    summary = learning_rate.summarise(runs)
    assert [row["failures"] for row in summary.rows[:3]] == [1, 0, 0]
    assert [bound.measured for bound in summary.bounds] == [30.0, 5.0]
    assert all(bound.holds for bound in summary.bounds)


def test_density_of_a_random_tip() -> None:
    """The saddle point density is that of random arms, and its integral is 1."""
    rng = np.random.default_rng(0)
    headings = rng.uniform(-np.pi, np.pi, (200_000, 10))
    radii = np.hypot(np.cos(headings).mean(axis=1), np.sin(headings).mean(axis=1))
    edges = np.linspace(0.05, 0.75, 8)
    counts, _ = np.histogram(radii, edges)
    middle = 0.5 * (edges[1:] + edges[:-1])
    expected = workspace.random_tip_density(middle, 10) * np.pi * np.diff(edges**2)
    np.testing.assert_allclose(counts / len(radii), expected, rtol=0.15)
    fine = np.linspace(0.0005, 0.9995, 1000)
    integral = np.sum(workspace.random_tip_density(fine, 50) * 2.0 * np.pi * fine) * 0.001
    assert integral == pytest.approx(1.0, abs=0.03)


def test_random_coverage_is_foretold() -> None:
    """At as many random samples as were said, the coverage is what was said."""
    samples = round(workspace.random_samples_for(0.17))
    settings = {"method": "random motor babbling", "samples": [samples]}
    (coverage,) = workspace.run(3, **settings)["coverage"]
    assert coverage == pytest.approx(0.17, abs=0.01)
    assert workspace.random_samples_for(0.8) > 1e12
