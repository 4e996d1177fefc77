"""A method on its own: it learns, and is measured by its answers to the goals.

The answers are tried without noise and without counting as samples.
"""

import itertools
import math

import numpy as np

from benchmarks.engine.experiment import Figures
from benchmarks.methods.method import Method
from bha_goal_babbling.straight_walk import straight_line

_GROWTH = 1.12
"""Factor of samples from one measurement of the error to the next."""


def trial(method: Method, samples: int) -> Figures:
    """Let a method learn in its world.

    Returns
    -------
    The error [m] after numbers of samples, those when it was at most a tenth of the first (None if
    never), the travel of the joints [rad] until then, and the largest jump of the joints [rad] in
    steps of 10 mm around the middle of the goals.
    """
    world = method.world
    counts, errors = [0], [world.error(method.inverse(world.goals))]
    tenth: int | None = None
    travel: float | None = None
    while world.samples < samples:
        method.run(_next_count(world.samples, samples) - world.samples)
        counts.append(world.samples)
        errors.append(world.error(method.inverse(world.goals)))
        if tenth is None and errors[-1] <= 0.1 * errors[0]:
            tenth, travel = world.samples, world.travel
    return {
        "counts": counts,
        "errors": errors,
        "samples_to_tenth": tenth,
        "travel_to_tenth": travel,
        "largest_jump": _largest_jump(method),
    }


def _next_count(count: int, last: int) -> int:
    """Return after how many samples the error is measured next; 1000 is among them."""
    wanted = max(count + 5, math.ceil(_GROWTH * count))
    if count < 1000 < wanted:
        wanted = 1000
    return min(wanted, last)


def _largest_jump(method: Method) -> float:
    """Return the largest |dq| [rad] in steps of 10 mm around a rectangle among the goals.

    The rectangle lies midway between the middle of the goals' box and its border.
    """
    goals = method.world.goals
    low, high = goals.min(axis=0), goals.max(axis=0)
    a, b = 0.75 * low + 0.25 * high, 0.25 * low + 0.75 * high
    corners = np.array([a, [b[0], a[1]], b, [a[0], b[1]], a])
    lines = [
        straight_line(start, end, round(float(np.linalg.norm(end - start)) / 0.01))
        for start, end in itertools.pairwise(corners)
    ]
    actions = method.inverse(np.concatenate(lines))
    return float(np.linalg.norm(np.diff(actions, axis=0), axis=1).max())
