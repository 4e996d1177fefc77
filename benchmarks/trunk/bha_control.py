"""The table `bha-control`: bellows brought to lengths by a learned equilibrium-point controller."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from statistics import mean, median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.engine.experiment import Bound, Experiment, Figures, Run, Settings, Summary
from benchmarks.trunk import equilibrium_models, model_age
from benchmarks.trunk.equilibrium_models import CONSTRAINED, LINEAR, MODELS, THIRD, USUAL
from benchmarks.trunk.length_control_methods import (
    LEARNED,
    METHODS,
    PID_CAREFUL,
    PID_FAST,
    controller,
)
from benchmarks.trunk.length_responses import (
    identified,
    is_stable,
    new_plant,
    reachable,
    resting,
    steps,
    tracking,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COUNTS = [30, 60, 120, 240]
_SAMPLES = 60  # what identification takes by default
_COLOURS = dict(zip(METHODS, ("#999999", "#56b4e9", "#0072b2", "#e69f00", "#d55e00"), strict=True))


def plan(quick: bool) -> Sequence[Settings]:
    """Return the runs of every robot: models, responses, age."""
    if quick:
        return [
            {"part": "models", "counts": [30]},
            {"part": "responses", "samples": 30, "targets": 3},
            {"part": "age", "hours": 0.5, "samples": 30},
        ]
    return [
        {"part": "models", "counts": _COUNTS},
        {"part": "responses", "samples": _SAMPLES, "targets": 11},
        {"part": "age", "hours": 3.0, "samples": _SAMPLES},
    ]


def run(seed: int, *, part: str, **settings: Any) -> Figures:
    """Make one part for one robot."""
    if part == "models":
        return equilibrium_models.compare(seed, **settings)
    if part == "age":
        return model_age.age(seed, **settings)
    return _responses(seed, **settings)


def _responses(seed: int, samples: int, targets: int) -> Figures:
    """Let every method go to the same targets from the same state of the robot."""
    plant = new_plant(seed)
    model, _ = identified(plant, samples, seed)
    goals = reachable(plant, targets, np.random.default_rng([seed, 2]))
    start, told = plant.save_state(), {}
    for method in METHODS:
        plant.restore_state(start)
        figures: Figures = dict(steps(plant, controller(method, model), goals))
        plant.restore_state(start)
        figures["tracking"] = tracking(plant, controller(method, model), goals[:5])
        plant.restore_state(start)
        figures["resting"] = resting(plant, controller(method, model), goals[:4])
        plant.restore_state(start)
        figures["margin of 2"] = is_stable(
            plant, partial(controller, method, model, 2.0), goals[:4]
        )
        told[method] = figures
    return told


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table: rows of models, then of responses, then of ages."""
    models, responses, ages = (_part(runs, part) for part in ("models", "responses", "age"))
    rows = [*_model_rows(models), *_response_rows(responses), *_age_rows(ages)]
    return Summary(rows, _bounds(models, responses, ages), _NOTE)


def _part(runs: Sequence[Run], part: str) -> list[Figures]:
    return [run.figures for run in runs if run.settings["part"] == part]


def _row(what: str, on: str, **columns: str) -> dict[str, Any]:
    heads = ("error [kPa]", "violations [%]", "lowest slope [kPa/mm]", "to 2 mm [s]")
    heads += ("overshoot [mm]", "second second, rms [mm]", "tracking [mm]", "tip at rest [mm]")
    heads += ("stable at twice the gain",)
    return {"what": what, "on": on, **{head: columns.get(head, "") for head in heads}}


def _model_rows(models: list[Figures]) -> list[dict[str, Any]]:
    rows = []
    for on in models[0]:
        for name in MODELS:
            told = [figures[on][name] for figures in models]
            lowest, certain = (min(each[key] for each in told) for key in ("lowest", "certain"))
            columns = {
                "error [kPa]": f"{mean(each['error'] for each in told):.2f}",
                "violations [%]": f"{max(each['falling'] for each in told):.2g} falling, "
                f"{max(each['outside'] for each in told):.2g} out of range",
                "lowest slope [kPa/mm]": f"{lowest:.2f} found, {certain:.2f} certain",
            }
            rows.append(_row(name, f"{on} samples", **columns))
    return rows


def _response_rows(responses: list[Figures]) -> list[dict[str, Any]]:
    rows = []
    for method in METHODS:
        columns = {
            "to 2 mm [s]": f"{_median(responses, method, 'all within'):.2f} all nine, "
            f"{_median(responses, method, 'rms within'):.2f} rms",
            "overshoot [mm]": f"{_median(responses, method, 'overshoot'):.2f} largest, "
            f"{_mean(responses, method, 'mean overshoot'):.2f} mean",
            "second second, rms [mm]": f"{_mean(responses, method, 'rms'):.2f}",
            "tracking [mm]": f"{mean(each[method]['tracking'] for each in responses):.2f}",
            "tip at rest [mm]": f"{mean(each[method]['resting'] for each in responses):.2f}",
            "stable at twice the gain": f"{sum(each[method]['margin of 2'] for each in responses)} "
            f"of {len(responses)}",
        }
        rows.append(_row(method, "steps", **columns))
    return rows


def _age_rows(ages: list[Figures]) -> list[dict[str, Any]]:
    rows = []
    for name, key in (("model as fitted", "fitted"), ("model that adapts", "adapted")):
        for index, end in enumerate(ages[0]["hours"]):
            error = mean(each[key][index] for each in ages)
            rows.append(
                _row(name, f"hour {end - 0.5:g} to {end:g}", **{"error [kPa]": f"{error:.2f}"})
            )
    return rows


def _median(responses: list[Figures], method: str, key: str) -> float:
    """Median over all steps of all robots."""
    return float(median(value for each in responses for value in each[method][key]))


def _mean(responses: list[Figures], method: str, key: str) -> float:
    return float(mean(value for each in responses for value in each[method][key]))


def _bounds(models: list[Figures], responses: list[Figures], ages: list[Figures]) -> list[Bound]:
    held = [figures[on][CONSTRAINED] for figures in models for on in figures]
    usual = [figures[on][USUAL] for figures in models for on in figures if on in ("30", THIRD)]
    stable = sum(each[LEARNED]["margin of 2"] for each in responses) / len(responses)
    bounds = [
        Bound.at_most(
            "violations of the constrained model, on any samples [%]",
            0.0,
            max(each["falling"] + each["outside"] for each in held),
        ),
        Bound.at_least(
            "slope below which no constrained model falls, for certain [kPa/mm]",
            0.0999,
            min(each["certain"] for each in held),
        ),
        Bound.at_least(
            "unconstrained ELMs on 30 samples or a third that violate a constraint [%]",
            100.0,
            1e2 * mean(float(each["falling"] + each["outside"] > 0.0) for each in usual),
        ),
        *(
            Bound.at_least(
                f"time to 2 mm ({how}) of {pid} over learned + low gain",
                2.0,
                _median(responses, pid, key) / _median(responses, LEARNED, key),
            )
            for pid in (PID_FAST, PID_CAREFUL)
            for how, key in (("all nine lengths", "all within"), ("rms of the nine", "rms within"))
        ),
        Bound.at_most(
            "overshoot of learned + low gain, largest of the nine bellows, median step [mm]",
            1.0,
            _median(responses, LEARNED, "overshoot"),
        ),
        Bound.at_most(
            "overshoot of learned + low gain, mean of the bellows [mm]",
            1.0,
            _mean(responses, LEARNED, "mean overshoot"),
        ),
        Bound.at_least("robots on which it is stable at twice the gain [%]", 100.0, 1e2 * stable),
    ]
    complete = all(str(count) in models[0] for count in _COUNTS)
    for count in (60, 120):
        gain = None
        if complete:
            gain = mean(f[str(count)][CONSTRAINED]["error"] for f in models) / mean(
                f[str(count)][LINEAR]["error"] for f in models
            )
        bounds.append(
            Bound.at_most(
                f"error of the constrained over the linear model, {count} samples", 1.0, gain
            )
        )
    hours = ages[0]["hours"]
    last = mean(each["adapted"][-1] / each["adapted"][0] for each in ages)
    bounds.append(
        Bound.at_most(
            "error of the adapting model in the last half hour over that in the first",
            1.2,
            last if hours[-1] >= 3.0 else None,
        )
    )
    rise = mean(float(each["still rises"]) for each in ages)
    bounds.append(
        Bound.at_least("adapting models that rise everywhere after hours [%]", 100.0, 1e2 * rise)
    )
    return bounds


def draw(runs: Sequence[Run], figure: Figure) -> None:
    """Draw errors over samples, times of the steps, and errors over hours."""
    models, responses, ages = (_part(runs, part) for part in ("models", "responses", "age"))
    left, middle, right = figure.subplots(1, 3)
    counts = [on for on in models[0] if on != THIRD]
    for name, colour in zip(MODELS, ("#999999", "#0072b2", "#56b4e9", "#d55e00"), strict=True):
        values = [mean(figures[on][name]["error"] for figures in models) for on in counts]
        left.plot([int(on) for on in counts], values, "o-", color=colour, label=name)
    left.set(xlabel="settled samples", ylabel="held-out error [kPa]", yscale="log", title="Models")
    left.legend(fontsize="small")
    for method, colour in _COLOURS.items():
        times = np.sort([t for each in responses for t in each[method]["rms within"]])
        middle.step(times, np.arange(1, len(times) + 1) / len(times), color=colour, label=method)
    middle.set(
        xlabel="time to 2 mm rms [s]", ylabel="share of the steps", title="Steps", xlim=(0.0, 4.0)
    )
    middle.legend(fontsize="small")
    for name, key in (("as fitted", "fitted"), ("adapts", "adapted")):
        values = np.mean([each[key] for each in ages], axis=0)
        right.plot(ages[0]["hours"], values, "o-", label=name)
    right.set(xlabel="hours of use", ylabel="error of the model [kPa]", title="Age")
    right.legend(fontsize="small")


_NOTE = (
    "Places are drawn over every length that can be commanded (0.1 to 0.4 m a bellows), half of "
    "them its corners; 'certain' is the bound in interval arithmetic over all of it at once. Steps "
    "go between typical postures, 8 s each; errors are those of the readings without noise and "
    "quantisation. The tip at rest is what it moves about its mean, rms over 10 s, 12 s after the "
    "command. PID only is PI: its derivative gain came out as 0."
)

EXPERIMENT = Experiment(
    name="bha-control",
    claim="the lengths are controlled by a learned equilibrium-point controller, since pressures "
    "alone are not enough and take up to 20 s to settle (section 4)",
    shows="errors and violations of equilibrium models over samples; steps and tracking of the "
    "lengths by pressure only, PID only, and learned + low gain; the model over hours of use",
    minutes=30.0,
    seeds=10,
    plan=plan,
    run=run,
    summarise=summarise,
    draw=draw,
)
"""The table `bha-control`."""
