"""The table `linear`: what theory says of linear problems, and what the learner does there."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.arm.linear_babbling import OUTCOMES, learn, target_variance
from benchmarks.arm.linear_theory import ignition_curve, inner_products
from benchmarks.engine.experiment import (
    Bound,
    Experiment,
    Figures,
    Run,
    Settings,
    Summary,
    runs_with,
)
from bha_goal_babbling.arrays import FloatArray

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Where the noise floor goes as sqrt(eta), the rate must fall as 1/t to end at the optimum.
_TO_THE_END = {"rates": [4e-4 / 2**k for k in range(6)], "samples": [3000 * 2**k for k in range(6)]}
_IGNITIONS = [(0.02, 0.05), (0.02, 0.1), (0.02, 0.2), (0.01, 0.1), (0.04, 0.1)]  # eta, s


def plan(quick: bool) -> Sequence[Settings]:
    """Return the gradients, the ignitions, and learning to the end."""
    to_the_end = {"rates": [4e-4, 1e-4], "samples": [2000, 2000]} if quick else _TO_THE_END
    return [
        {"part": "gradients", "problems": 100},
        *(
            # About three times as long as until half of the reach.
            {"part": "ignition", "rate": rate, "spread": spread, "samples": int(15 / rate / spread)}
            for rate, spread in (_IGNITIONS[2:3] if quick else _IGNITIONS)
        ),
        {"part": "end", "spread": 1.5, **to_the_end},
    ]


def run(seed: int, *, part: str, **settings: Any) -> Figures:
    """Make one part for one seed."""
    if part == "gradients":
        products, cosines = inner_products(np.random.default_rng([seed, 1]), **settings)
        return {"inner_products": products, "cosines": cosines}
    rng = np.random.default_rng([seed, 2])
    if part == "ignition":
        rate, samples = settings.pop("rate"), settings.pop("samples")
        return learn(rng, "none", rates=[rate], samples=[samples], **settings)
    return learn(rng, "plain", **settings)


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table."""
    products = [
        p for run in runs_with(runs, part="gradients") for p in run.figures["inner_products"]
    ]
    cosines = [c for run in runs_with(runs, part="gradients") for c in run.figures["cosines"]]
    distances = [run.figures["distances"][-1] for run in runs_with(runs, part="end")]
    unreached = [run.figures["unreached"][-1] for run in runs_with(runs, part="end")]
    asked = sum(runs_with(runs, part="end")[0].settings["samples"])
    smallest, farthest = min(products), max(distances)
    long_enough = asked >= sum(_TO_THE_END["samples"])
    rows = [
        _row(f"smallest inner product of the gradients, {len(products)} problems", 0.0, smallest),
        _row("smallest cosine of the gradients", 0.0, min(cosines)),
        _row(f"goals not reached after {asked} samples, median [%]", None, 100 * median(unreached)),
        _row("distance to the pseudo-inverse, median [%]", 0.0, 100 * median(distances)),
        _row("distance to the pseudo-inverse, worst seed [%]", 0.0, 100 * farthest),
    ]
    for (rate, spread), members in _ignitions(runs).items():
        counts = np.array(members[0].figures["samples"], dtype=float)
        for share in (0.1, 0.5):
            expected = _first(counts, _expected(rate, spread, counts), share)
            measured = median([_first(counts, _reached(run), share) for run in members])
            name = f"samples to {share:.0%} of the reach, eta {rate:g}, s {spread:g}, median"
            rows.append(_row(name, expected, measured))
    bounds = [
        Bound.at_least("smallest inner product of the gradients", -1e-12, smallest),
        Bound.at_most(
            "distance to the pseudo-inverse, worst seed [%]",
            1.0,
            100 * farthest if long_enough else None,
        ),
    ]
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw how learning ignites, grows and saturates, and how it ends at the pseudo-inverse."""
    left, right = figure.subplots(1, 2)
    for colour, ((rate, spread), members) in zip(
        ("#0072b2", "#009e73", "#d55e00", "#cc79a7", "#e69f00"),
        _ignitions(runs).items(),
        strict=False,
    ):
        counts = np.array(members[0].figures["samples"], dtype=float)
        reached = np.median([_reached(run) for run in members], axis=0)
        left.semilogx(counts, reached, color=colour, label=f"η = {rate:g}, s = {spread:g}")
        left.semilogx(counts, _expected(rate, spread, counts), ":", color=colour)
    left.plot([], [], ":", color="#444444", label="theory")
    left.set(
        xlabel="samples",
        ylabel="share of the reach, 1 - |1 - F dg/dx|",
        title="Ignition, growth, saturation",
    )
    left.legend(fontsize="small")
    for number, run in enumerate(runs_with(runs, part="end")):
        label = "one problem each" if number == 0 else None
        right.loglog(
            run.figures["samples"],
            run.figures["distances"],
            color="#0072b2",
            alpha=0.5,
            linewidth=1.0,
            label=label,
        )
    right.axhline(0.01, color="#444444", linestyle="--", label="1 %")
    right.set(
        xlabel="samples",
        ylabel="distance of dg/dx to the pseudo-inverse, relative",
        title="The end is the least-squares inverse",
    )
    right.legend(fontsize="small")


def _row(what: str, expected: float | None, measured: float) -> dict[str, Any]:
    return {"what": what, "theory": expected, "ours": measured}


def _ignitions(runs: Sequence[Run]) -> dict[tuple[float, float], list[Run]]:
    """Return the runs by learning rate and noise."""
    found: dict[tuple[float, float], list[Run]] = {}
    for run in runs_with(runs, part="ignition"):
        found.setdefault((run.settings["rate"], run.settings["spread"]), []).append(run)
    return found


def _reached(run: Run) -> FloatArray:
    return 1.0 - np.asarray(run.figures["unreached"])


def _expected(rate: float, spread: float, counts: FloatArray) -> FloatArray:
    """Return the share of the reach by theory after numbers of samples, same shape."""
    return ignition_curve(rate, spread, counts, OUTCOMES, target_variance())


def _first(counts: FloatArray, reached: FloatArray, share: float) -> float:
    """Return the count at which a curve comes to a share; NaN if it does not."""
    there = np.flatnonzero(reached >= share)
    return float(counts[there[0]]) if there.size else float("nan")


_NOTE = (
    "The article states both without numbers. The curve by theory is that of the mean step with a "
    "homogeneous estimate; ours has a value to learn besides the slope, and two directions that "
    "ignite one after the other, so it takes somewhat longer to half of the reach. The end is with "
    "both weights and a learning rate that falls as 1/t; with a constant one a distance of about "
    "sqrt(eta) remains."
)

EXPERIMENT = Experiment(
    name="linear",
    claim="for linear problems the gradients of E^Q and E^X have a non-negative inner product, and "
    "goal babbling ends at the optimal least-squares inverse (sections 1 and 3); learning ignites "
    "like a combustion (section 4)",
    shows="smallest inner product on random problems, distance to the pseudo-inverse, ignition",
    minutes=6.0,
    seeds=11,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `linear`."""
