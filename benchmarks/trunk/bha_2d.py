"""Reaching to the side with the trunk, learned on the robot from nothing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from benchmarks.engine.experiment import Bound, Experiment, Run, Summary
from benchmarks.trunk.bha_learning import draw, plan, robots_after, rows_of, run
from benchmarks.trunk.bha_runs import BODY


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every method and exploration time."""
    bounds = []
    for minute in (30.0, 60.0, 90.0):
        robots = robots_after(runs, BODY, minute)
        mean, worst = (None, None) if robots is None else (robots.mean(), robots.max())
        bounds.append(Bound.at_most(f"{BODY}, mean error at {minute:g} min [mm]", 10.0, mean))
        bounds.append(Bound.at_most(f"{BODY}, worst robot at {minute:g} min [mm]", 12.0, worst))
    return Summary(rows_of(runs), bounds, _NOTE)


_NOTE = (
    "The article says accurately, and gives no number for feed-forward control alone. Its own "
    "method is the row goal babbling. The body model (docs/learner.md) follows the drift of the "
    "potentiometers, which alone cost 4 to 6 mm (table bha-plant), on the way to these goals as "
    "well (`learn_in_use: offsets`, the default); nothing else is learned there."
)

EXPERIMENT = Experiment(
    name="bha-2d",
    claim="left/right and forward/backward controlled accurately after less than 30 minutes of "
    "exploration (section 4)",
    shows="feed-forward error on held-out goals over exploration time, up to 90 robot minutes",
    minutes=30.0,
    seeds=10,
    plan=partial(plan, "2d"),
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `bha-2d`."""
