"""Direction sampling finds the whole workspace of an arm with 50 joints; random angles never do."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq
from scipy.special import i0e, i1e

from benchmarks.arm.compiled_reaching import compiled_babbler
from benchmarks.arm.configs import FAST
from benchmarks.arm.reaching import LIMIT, ReachingTask
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
from bha_goal_babbling.direction_sampling import DirectionTargets

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_JOINTS = 50
_CELL = 0.1  # [m]
_STEP = 0.15  # eps of direction sampling [m]: a step must show above the noise of 50 joints
_CONFIG = dataclasses.replace(FAST, map_distance=0.1, noise_spread=0.05, noise_step=0.05)
_MARKS = (1_000, 10_000, 100_000, 1_000_000)  # samples
_DIRECTIONS, _RANDOM = "direction sampling", "random motor babbling"
_CHUNK = 10_000


def plan(quick: bool) -> Sequence[Settings]:
    """Return both methods."""
    marks = _MARKS[:2] if quick else _MARKS
    return [{"method": method, "samples": list(marks)} for method in (_DIRECTIONS, _RANDOM)]


def run(seed: int, *, method: str, samples: list[int]) -> Figures:
    """Explore, and count the cells the tip has been in at each mark.

    Returns
    -------
    dict
        `coverage`: visited cells over cells within reach, an entry a mark.
    """
    task = ReachingTask(_JOINTS)
    babbler = compiled_babbler(task, _CONFIG, seed, DirectionTargets(_STEP, 2))
    rng = np.random.default_rng(seed)
    within_reach = len(cells_within_reach(task.arm.length))
    side = math.ceil(task.arm.length / _CELL) + 1
    visited = np.zeros((2 * side, 2 * side), dtype=bool)
    coverage, made = [], 0
    for mark in samples:
        while made < mark:
            count = min(_CHUNK, mark - made)
            if method == _DIRECTIONS:
                tips = babbler.run(count)
            else:
                tips = task.arm.forward(rng.uniform(-LIMIT, LIMIT, (count, _JOINTS)))
            cells = np.floor(tips / _CELL).astype(int) + side
            visited[cells[:, 0], cells[:, 1]] = True
            made += count
        coverage.append(int(visited.sum()) / within_reach)
    return {"coverage": coverage}


def cells_within_reach(length: float) -> FloatArray:
    """Return the centres of the cells that lie within reach [m], shape (cells, 2).

    A cell counts by its centre. The tip also visits cells at the rim whose centre is outside, so
    that full coverage is a little above 1.
    """
    side = math.ceil(length / _CELL)
    axis = (np.arange(-side, side) + 0.5) * _CELL
    centres = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    return centres[np.linalg.norm(centres, axis=1) <= length]


def random_tip_density(radii: FloatArray, joints: int) -> FloatArray:
    """Return the density of the tip of an arm of 1 m with random joints [1/m^2].

    Headings are independent and uniform, so the tip is the mean of m random unit vectors. This is
    the saddle point approximation of its density: with A = I1/I0 and A(t) = r,
    p(r) = m / (2 pi sqrt(A'(t) A(t)/t)) (I0(t) exp(-t r))^m. It is exact to O(1/m), far out as
    well, where the normal approximation is wrong by many orders.

    Parameters
    ----------
    radii : Distances from the base r [m], each above 0 and below 1.
    joints : Number m of joints.
    """
    density = []
    for radius in radii:
        tilt = brentq(lambda t, r=radius: i1e(t) / i0e(t) - r, 1e-9, 1e6)
        slope = 1.0 - radius**2 - radius / tilt
        exponent = math.log(i0e(tilt)) + tilt - tilt * radius
        spread = math.sqrt(slope * radius / tilt)
        density.append(joints / (2.0 * math.pi * spread) * math.exp(joints * exponent))
    return np.array(density)


@functools.cache
def _random_chances() -> FloatArray:
    """Return the chance that a random arm's tip is in a cell within reach, shape (cells,).

    The density changes by much within a cell: it is averaged over the cell, by its radius.
    """
    radii = np.linspace(0.001, 0.999, 999)
    density = random_tip_density(radii, _JOINTS)
    offsets = (np.arange(8) + 0.5) / 8.0 * _CELL - 0.5 * _CELL
    inner = np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
    points = cells_within_reach(1.0)[:, np.newaxis] + inner
    chances: FloatArray = _CELL**2 * np.interp(
        np.linalg.norm(points, axis=-1), radii, density, right=0.0
    ).mean(axis=1)
    return chances


def random_samples_for(coverage: float) -> float:
    """Return the number of random samples at which a coverage is expected."""
    chances = _random_chances()

    def lacking(exponent: float) -> float:
        return coverage - float(np.mean(-np.expm1(-(10.0**exponent) * chances)))

    return float(10.0 ** brentq(lacking, 0.0, 200.0))


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every method and number of samples."""
    rows, coverage = [], {}
    for method in (_DIRECTIONS, _RANDOM):
        members = runs_with(runs, method=method)
        for index, mark in enumerate(members[0].settings["samples"] if members else []):
            values = [made.figures["coverage"][index] for made in members]
            coverage[method, mark] = median(values)
            rows.append(
                {
                    "method": method,
                    "samples": mark,
                    "coverage, median [-]": median(values),
                    "lowest [-]": min(values),
                    "random samples for this coverage, expected": random_samples_for(
                        min(median(values), 0.99)
                    ),
                }
            )
    bounds = [
        Bound.at_least(
            "coverage by direction sampling after 1e6 samples",
            1.0,
            coverage.get((_DIRECTIONS, 1_000_000)),
        ),
        Bound.at_most(
            "coverage by random motor babbling after 1e6 samples",
            0.3,
            coverage.get((_RANDOM, 1_000_000)),
        ),
        Bound.at_least(
            "coverage by direction sampling after 1e4 samples",
            0.8,
            coverage.get((_DIRECTIONS, 10_000)),
        ),
    ]
    return Summary(rows, bounds, _NOTE)


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw coverage over samples, and what random motor babbling would need for more."""
    axes = figure.subplots()
    for method in (_DIRECTIONS, _RANDOM):
        members = runs_with(runs, method=method)
        if members:
            values = np.median([made.figures["coverage"] for made in members], axis=0)
            axes.semilogx(members[0].settings["samples"], values, "o-", label=method)
    levels = np.linspace(0.1, 0.95, 40)
    axes.semilogx(
        [random_samples_for(level) for level in levels],
        levels,
        ":",
        color="0.5",
        label="random motor babbling, expected",
    )
    axes.axhline(1.0, color="0.8", linewidth=1.0)
    axes.set(
        xlabel="samples",
        ylabel="visited cells of 10 cm over those within reach",
        title="Workspace of an arm with 50 joints, limits ±180 degrees",
    )
    axes.legend(fontsize="small")


_NOTE = (
    "Limits are +-pi. What random motor babbling needs is extrapolated by the density of a random "
    "arm's tip, for at most 0.99 of the cells; with narrower limits it does better."
)

EXPERIMENT = Experiment(
    name="workspace",
    claim="direction sampling covers the unknown workspace of an arm with 50 joints in 1e6 "
    "samples, for which random motor babbling needs 1e14 (section 4)",
    shows="coverage of cells over samples, and the extrapolated cost of random motor babbling",
    minutes=5.0,
    seeds=11,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `workspace`."""
