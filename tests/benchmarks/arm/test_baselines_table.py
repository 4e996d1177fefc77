"""The table `baselines`: runs of every method, and what is made of runs."""

import math
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks.arm.baselines import EXPERIMENT, METHODS, run
from benchmarks.engine.experiment import Run


@pytest.mark.parametrize("method", METHODS)
def test_every_method_runs_and_repeats(method: str) -> None:
    """Errors are finite, start alike for all, and come again with the same seed."""
    figures = run(7, method, joints=3, samples=20)
    assert figures["counts"][-1] == 20
    assert all(math.isfinite(error) for error in figures["errors"])
    assert figures["errors"][0] == pytest.approx(run(8, method, 3, 5)["errors"][0])
    assert figures == run(7, method, joints=3, samples=20)
    assert math.isfinite(figures["largest_jump"])


def test_goal_babbling_gets_there_and_moves_smoothly() -> None:
    """The run finds the tenth at the first measurement that is one."""
    figures = run(0, "goal babbling (fast)", joints=2, samples=1500)
    errors, tenth = np.array(figures["errors"]), figures["samples_to_tenth"]
    assert tenth is not None
    index = figures["counts"].index(tenth)
    assert errors[index] <= 0.1 * errors[0] < errors[1:index].min()
    assert 0.0 < figures["travel_to_tenth"] < 1500
    assert 1000 in figures["counts"]


def made_run(seed: int, method: str, tenth: int | None, final: float, jump: float) -> Run:
    figures: dict[str, Any] = {
        "counts": [0, 1000, 10_000],
        "errors": [0.5, 2.0 * final, final],
        "samples_to_tenth": tenth,
        "travel_to_tenth": None if tenth is None else 0.1 * tenth,
        "largest_jump": jump,
    }
    return Run(seed, {"method": method, "joints": 50, "samples": 10_000}, figures)


def made_runs(nearest_jump: float) -> list[Run]:
    runs = []
    for seed in range(3):
        for method, contender in METHODS.items():
            if contender.ours:
                runs.append(made_run(seed, method, [100, 200, None][seed], 0.01, 0.1))
            elif method == "nearest neighbour":
                runs.append(made_run(seed, method, 300, 0.02, nearest_jump))
            else:
                # What knows the Jacobian is quicker than all, and must not count.
                tenth = 10 if contender.knows_jacobian else None
                runs.append(made_run(seed, method, tenth, 0.2, 1.0))
    return runs


def test_rows_are_medians_in_which_never_is_the_largest() -> None:
    rows = {row["method"]: row for row in EXPERIMENT.summarise(made_runs(2.0)).rows}
    ours, others = rows["goal babbling (fast)"], rows["direct fit, all angles"]
    assert (ours["samples to 10 %"], ours["never"]) == (200.0, "1 of 3")
    assert (ours["error after 1000 [mm]"], ours["error after 10000 [mm]"]) == (20.0, 10.0)
    assert (others["samples to 10 %"], others["never"]) == (None, "3 of 3")


def test_bounds_follow_from_the_runs() -> None:
    good = EXPERIMENT.summarise(made_runs(2.0)).bounds
    assert [bound.measured for bound in good] == pytest.approx([20.0, 20.0, 200 / 300, 0.05])
    assert all(bound.holds for bound in good)
    bad = EXPERIMENT.summarise(made_runs(0.5)).bounds
    assert [bound.holds for bound in bad] == [True, True, True, False]


def test_who_alone_gets_there_leads() -> None:
    """And who never does has no figure, which is no success."""
    alone = [run for run in made_runs(2.0) if run.settings["method"] != "nearest neighbour"]
    assert EXPERIMENT.summarise(alone).bounds[2].measured == 0.0
    without = [run for run in made_runs(2.0) if not METHODS[run.settings["method"]].ours]
    bound = EXPERIMENT.summarise(without).bounds[2]
    assert (bound.measured, bound.holds) == (None, False)


def test_draws_an_axis_each_arm() -> None:
    figure = Figure()
    EXPERIMENT.draw(made_runs(1.0), figure)
    assert [axis.get_title() for axis in figure.axes] == ["50 joints"]
    assert len(figure.axes[0].get_lines()) == len(METHODS) + 1


def test_quick_plan_is_a_part_of_the_whole() -> None:
    quick, whole = EXPERIMENT.plan(True), EXPERIMENT.plan(False)
    assert {run["method"] for run in quick} == set(METHODS)
    assert {run["joints"] for run in whole} == {2, 10, 20, 50}
    assert max(run["samples"] for run in quick) < min(run["samples"] for run in whole)
