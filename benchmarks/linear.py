"""Goal babbling on linear problems, x = F q: what theory says, and what the learner does.

The estimate is g(x*) = G x*. With exploratory noise an example is q = (G + A) x*, x = F q.

    E^Q = sum |q - G x|^2,   dE^Q/dG = -2 sum (q - G x) x'      (fitting examples)
    E^X = sum |x* - F G x*|^2,   dE^X/dG = -2 F' sum (x* - F G x*) x*'   (reaching goals)

(equations 2 and following of the article; examples count as given, as they do online). For goals
and noise without a preferred direction the two gradients never oppose each other (Rolf and Steil,
"Explorative learning of inverse models: a theoretical perspective", 2014): with D = F G their inner
product is 4 (|D - D^2|^2 + n s^2 |(1 - D) F|^2).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.experiment import Bound, Experiment, Figures, Run, Settings, Summary
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.local_linear_map import LocalLinearMaps
from bha_goal_babbling.saved_state import SavedState

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ACTIONS, _OUTCOMES = 4, 2
_VALUE_RATE = 0.3  # eta of the value of the one map
_PATH_STEPS = 5
_CURVE_POINTS = 60

# Where the noise floor goes as sqrt(eta), the rate must fall as 1/t to end at the optimum.
_TO_THE_END = {"rates": [4e-4 / 2**k for k in range(6)], "samples": [3000 * 2**k for k in range(6)]}
_IGNITIONS = [(0.02, 0.05), (0.02, 0.1), (0.02, 0.2), (0.01, 0.1), (0.04, 0.1)]  # eta, s


def gradient_of_examples(
    estimate: FloatArray, forward: FloatArray, goals: FloatArray, noises: FloatArray
) -> FloatArray:
    """Return dE^Q/dG over all pairs of a goal and a noise, shape (m, n).

    Parameters
    ----------
    estimate : array
        G, shape (m, n).
    forward : array
        F, shape (n, m).
    goals : array
        Shape (g, n).
    noises : array
        Matrices A, shape (a, m, n).
    """
    gradient = np.zeros_like(estimate)
    for noise in noises:
        actions = goals @ (estimate + noise).T
        outcomes = actions @ forward.T
        gradient -= 2.0 * (actions - outcomes @ estimate.T).T @ outcomes
    return gradient / len(noises)


def gradient_of_reaching(
    estimate: FloatArray, forward: FloatArray, goals: FloatArray
) -> FloatArray:
    """Return dE^X/dG over all goals, shape (m, n); see `gradient_of_examples`."""
    return -2.0 * forward.T @ (goals - goals @ (forward @ estimate).T).T @ goals


def isotropic_noises(spread: float, m: int, n: int) -> FloatArray:
    """Return matrices A with mean 0 and the covariance of independent entries N(0, s^2).

    E^Q is quadratic in A, so its mean over these few is exactly that over the distribution.

    Returns
    -------
    array
        Shape (2 m n, m, n).
    """
    entries = spread * np.sqrt(m * n) * np.eye(m * n).reshape(-1, m, n)
    return np.concatenate([entries, -entries])


def _inner_products(seed: int, problems: int) -> Figures:
    """Return the inner product of the two gradients, and its cosine, on random problems."""
    rng = np.random.default_rng([seed, 1])
    products, cosines = [], []
    for _ in range(problems):
        n = int(rng.integers(1, 4))
        m = int(rng.integers(n, 21))
        forward = rng.standard_normal((n, m)) / np.sqrt(m)
        # From no estimate to a wild one, from no noise to much; and near what is optimal.
        estimate = rng.choice([0.0, 0.1, 1.0, 3.0]) * rng.standard_normal((m, n))
        estimate += rng.choice([0.0, 1.0]) * np.linalg.pinv(forward)
        goals = np.sqrt(n) * np.linalg.qr(rng.standard_normal((n, n)))[0]
        noises = isotropic_noises(rng.choice([0.0, 0.1, 1.0]), m, n)
        by_examples = gradient_of_examples(estimate, forward, goals, noises)
        by_reaching = gradient_of_reaching(estimate, forward, goals)
        products.append(float(np.sum(by_examples * by_reaching)))
        length = np.linalg.norm(by_examples) * np.linalg.norm(by_reaching)
        if length > 1e-9:
            cosines.append(products[-1] / float(length))
    return {"inner_products": products, "cosines": cosines}


def _learning(
    seed: int, weights: str, spread: float, rates: Sequence[float], samples: Sequence[int]
) -> Figures:
    """Return how far goal babbling is from reaching, and from the pseudo-inverse, as it learns.

    With a slope G = dg/dx, the unreached share is |1 - F G| / |1|, and the distance is
    |G - F^+| / |F^+|.

    Parameters
    ----------
    weights : str
        "plain" or "none", for w_dir and w_eff both.
    spread : float
        Noise s.
    rates, samples : sequences
        Learning rates of the slope, one after the other, and for how many samples each.
    """
    rng = np.random.default_rng([seed, 2])
    forward = np.linalg.qr(rng.standard_normal((_ACTIONS, _OUTCOMES)))[0].T
    best = np.linalg.pinv(forward)
    axis = np.linspace(-1.0, 1.0, 5)
    goals = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, _OUTCOMES)
    home, start, limits = np.zeros(_ACTIONS), np.zeros(_OUTCOMES), np.full(_ACTIONS, 1e3)
    # One map that reaches beyond all outcomes is a linear model. Its slope learns at the rate
    # eta / d^2, its value at eta.
    reach = math.sqrt(_VALUE_RATE / rates[0])
    maps = LocalLinearMaps(reach, _VALUE_RATE, start, home)
    counts: list[int] = []
    unreached: list[float] = []
    distances: list[float] = []
    for rate, share in zip(rates, samples, strict=True):
        maps = _with_rate(maps, rate * reach**2)
        config = GoalBabblerConfig(
            noise_spread=spread,
            noise_step=3.0 * spread,
            path_steps=_PATH_STEPS,
            home_probability=0.0,
            direction=weights,
            efficiency=weights,
        )
        babbler = GoalBabbler(config, goals, home, start, -limits, limits, rng, model=maps)
        done = counts[-1] if counts else 0
        for mark in np.unique(np.geomspace(10, share, _CURVE_POINTS).astype(int)):
            while babbler.samples < mark:
                action = babbler.ask()
                babbler.tell(action, forward @ action)
            slope = maps.slope(start)
            counts.append(done + int(mark))
            unreached.append(_relative(forward @ slope, np.eye(_OUTCOMES)))
            distances.append(_relative(slope, best))
    return {
        "samples": counts,
        "unreached": unreached,
        "distances": distances,
        "local_maps": maps.count,
    }


def _with_rate(maps: LocalLinearMaps, rate: float) -> LocalLinearMaps:
    """Return the maps as they are, to go on with another learning rate."""
    state = maps.state()
    return LocalLinearMaps.restore(
        SavedState(state.arrays, {**state.settings, "learning_rate": rate})
    )


def _relative(found: FloatArray, right: FloatArray) -> float:
    return float(np.linalg.norm(found - right) / np.linalg.norm(right))


def ignition_curve(rate: float, spread: float, samples: FloatArray) -> FloatArray:
    """Return the share D of the reach after some samples by theory, same shape.

    Without weights, with goals along straight paths of variance sigma^2 a coordinate and noise
    A x* + c, the mean step of D = F G is

        dD/dt = eta (1 - D) (sigma^2 D^2 + s^2 (n sigma^2 + 1)).

    First the noise alone drives it (ignition, D ~ eta s^2 t), then D^2 (growth that feeds itself),
    then 1 - D ends it (saturation).
    """
    # A coordinate of the goals is one of -1, -1/2, 0, 1/2, 1: variance 1/2; on the way from one
    # to the next the two ends mix.
    mixed = np.arange(1, _PATH_STEPS + 1) / _PATH_STEPS
    variance = 0.5 * float(np.mean(mixed**2 + (1.0 - mixed) ** 2))

    def step(_: float, reach: FloatArray) -> FloatArray:
        driven: FloatArray = variance * reach**2 + spread**2 * (_OUTCOMES * variance + 1.0)
        return rate * (1.0 - reach) * driven

    solution = solve_ivp(step, (0.0, float(samples[-1])), [0.0], t_eval=samples, rtol=1e-8)
    reach: FloatArray = solution.y[0]
    return reach


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
        return _inner_products(seed, **settings)
    if part == "ignition":
        rate, samples = settings.pop("rate"), settings.pop("samples")
        return _learning(seed, "none", rates=[rate], samples=[samples], **settings)
    return _learning(seed, "plain", **settings)


def summarise(runs: Sequence[Run]) -> Summary:
    """Make the table."""
    products = [p for run in _of(runs, "gradients") for p in run.figures["inner_products"]]
    cosines = [c for run in _of(runs, "gradients") for c in run.figures["cosines"]]
    distances = [run.figures["distances"][-1] for run in _of(runs, "end")]
    unreached = [run.figures["unreached"][-1] for run in _of(runs, "end")]
    asked = sum(_of(runs, "end")[0].settings["samples"])
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
            expected = _first(counts, ignition_curve(rate, spread, counts), share)
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
        left.semilogx(counts, ignition_curve(rate, spread, counts), ":", color=colour)
    left.plot([], [], ":", color="#444444", label="theory")
    left.set(
        xlabel="samples",
        ylabel="share of the reach, 1 - |1 - F dg/dx|",
        title="Ignition, growth, saturation",
    )
    left.legend(fontsize="small")
    for number, run in enumerate(_of(runs, "end")):
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


def _of(runs: Sequence[Run], part: str) -> list[Run]:
    return [run for run in runs if run.settings["part"] == part]


def _ignitions(runs: Sequence[Run]) -> dict[tuple[float, float], list[Run]]:
    """Return the runs by learning rate and noise."""
    found: dict[tuple[float, float], list[Run]] = {}
    for run in _of(runs, "ignition"):
        found.setdefault((run.settings["rate"], run.settings["spread"]), []).append(run)
    return found


def _reached(run: Run) -> FloatArray:
    return 1.0 - np.asarray(run.figures["unreached"])


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
