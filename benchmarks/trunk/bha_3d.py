"""Reaching in all three dimensions with the trunk, learned on the robot from nothing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from benchmarks.engine.experiment import Bound, Experiment, Run, Summary
from benchmarks.trunk.bha_learning import draw, plan, robots_after, rows_of, run
from benchmarks.trunk.bha_runs import BODY


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: a row for every method and exploration time, errors a direction too."""
    hour, late = robots_after(runs, BODY, 60.0), robots_after(runs, BODY, 90.0)
    bounds = [
        Bound.at_most(
            f"{BODY}, mean error at 60 min [mm]", 10.0, None if hour is None else hour.mean()
        ),
        Bound.at_most(
            f"{BODY}, worst robot at 60 min [mm]", 15.0, None if hour is None else hour.max()
        ),
        Bound.at_most(
            f"{BODY}, worst robot at 90 min [mm]", 12.0, None if late is None else late.max()
        ),
    ]
    return Summary(rows_of(runs), bounds, _NOTE)


_NOTE = (
    "The article has about 20 mm after a few hours; its own method is the row goal babbling. "
    "Without a body model (docs/learner.md) the largest errors are near the base and far to the "
    "side, where bellows are sent to lengths that they cannot have."
)

EXPERIMENT = Experiment(
    name="bha-3d",
    claim="all three dimensions controlled within few hours, to about 2 cm (section 4)",
    shows="feed-forward error on held-out goals over exploration time, and its directions",
    minutes=30.0,
    seeds=10,
    plan=partial(plan, "3d"),
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `bha-3d`."""
