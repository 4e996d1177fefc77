"""The table `interest`: runs of every choice, and what is made of runs."""

import pytest
from matplotlib.figure import Figure

from benchmarks.arm.interest import CHOICES, EXPERIMENT, LEARNERS, run
from benchmarks.engine.experiment import Run


@pytest.mark.parametrize("choice", CHOICES)
def test_every_choice_learns(choice: str) -> None:
    """An error each movement, the tenth where it is first reached, the same for the same seed."""
    figures = run(3, choice, "fast", joints=2, movements=40)
    errors, tenth = figures["errors"], figures["movements_to_tenth"]
    assert len(errors) == 41
    assert errors[tenth] <= 0.1 * errors[0] < min(errors[:tenth])
    assert figures == run(3, choice, "fast", joints=2, movements=40)


def test_choices_differ() -> None:
    """The same seed leads elsewhere."""
    ends = {choice: run(3, choice, "fast", 2, 5)["errors"][-1] for choice in CHOICES}
    assert len(set(ends.values())) == len(CHOICES)


def made_runs(interest: list[int | None]) -> list[Run]:
    movements = {"random": [10, 20, 40], "interest": interest, "SAGG-RIAC": [None, None, 30]}
    return [
        Run(
            seed,
            {"choice": choice, "learner": learner, "joints": 2, "movements": 2},
            {"errors": [0.5, 0.1, 0.02], "movements_to_tenth": movements[choice][seed]},
        )
        for seed in range(3)
        for choice in CHOICES
        for learner in LEARNERS
    ]


def test_rows_are_quantiles_in_which_never_is_the_largest() -> None:
    rows = {
        row["goals chosen by"]: row
        for row in EXPERIMENT.summarise(made_runs([5, 10, None])).rows
        if row["settings"] == "fast"
    }
    columns = ("lower quartile", "movements to 10 %", "upper quartile", "never")
    assert [rows["random"][name] for name in columns] == [20, 20, 40, "0 of 3"]
    assert [rows["interest"][name] for name in columns] == [10, 10, None, "1 of 3"]
    assert rows["SAGG-RIAC"]["movements to 10 %"] is None
    assert rows["random"]["error after 2 movements [mm]"] == 20.0


@pytest.mark.parametrize(
    ("interest", "measured", "holds"),
    [([5, 10, None], 0.5, True), ([30, 30, 30], 1.5, False), ([None] * 3, None, False)],
)
def test_bounds_follow_from_the_runs(
    interest: list[int | None], measured: float | None, holds: bool
) -> None:
    bounds = EXPERIMENT.summarise(made_runs(interest)).bounds
    assert [(bound.measured, bound.holds) for bound in bounds] == [
        (None if measured is None else pytest.approx(measured), holds)
    ] * len(LEARNERS)


def test_an_arm_that_is_never_learned_is_not_left_out() -> None:
    """Good ratios elsewhere do not make up for it."""
    there, never = made_runs([5, 10, 10]), made_runs([None] * 3)
    other_arm = [Run(run.seed, {**run.settings, "joints": 20}, run.figures) for run in never]
    bounds = EXPERIMENT.summarise(there + other_arm).bounds
    assert [bound.measured for bound in bounds] == [None] * len(LEARNERS)


def test_draws_an_axis_each_arm_and_learner() -> None:
    figure = Figure()
    EXPERIMENT.draw(made_runs([5, 10, 20]), figure)
    assert len(figure.axes) == len(LEARNERS)
    assert len(figure.axes[0].get_lines()) == 2 * len(CHOICES)


def test_quick_plan_is_shorter() -> None:
    quick, whole = EXPERIMENT.plan(True), EXPERIMENT.plan(False)
    assert len(quick) < len(whole)
    assert {run["choice"] for run in quick} == set(CHOICES)
