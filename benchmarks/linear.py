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

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.experiment import Bound, Experiment, Figures, Run, Settings, Summary
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_JOINTS, _OUTCOMES = 10, 2
_REACH = 10.0  # of the one map, beyond all outcomes; its slopes then learn at rate eta / _REACH^2
_RATES = (0.002, 0.004, 0.008)  # of the slope dg/dx
_SPREADS = (0.025, 0.05, 0.1)
_CURVE_POINTS = 60


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


def _learning(seed: int, rate: float, spread: float, samples: int) -> Figures:
    """Return how far goal babbling is from the pseudo-inverse while it learns."""
    rng = np.random.default_rng([seed, 2])
    forward = np.linalg.qr(rng.standard_normal((_JOINTS, _OUTCOMES)))[0].T
    best = np.linalg.pinv(forward)
    axis = np.linspace(-1.0, 1.0, 5)
    goals = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, _OUTCOMES)
    config = GoalBabblerConfig(
        map_distance=_REACH,
        learning_rate=rate * _REACH**2,
        noise_spread=spread,
        noise_step=3.0 * spread,
        path_steps=5,
    )
    limits = np.full(_JOINTS, 1e3)
    babbler = GoalBabbler(
        config, goals, np.zeros(_JOINTS), np.zeros(_OUTCOMES), -limits, limits, rng
    )
    marks = np.unique(np.geomspace(10, samples, _CURVE_POINTS).astype(int))
    errors, distances = [], []
    for mark in marks:
        while babbler.samples < mark:
            action = babbler.ask()
            babbler.tell(action, forward @ action)
        actions = babbler.inverse(goals)
        errors.append(_relative(actions @ forward.T, goals))
        distances.append(_relative(actions, goals @ best.T))
    return {"samples": marks, "errors": errors, "distances": distances}


def _relative(found: FloatArray, right: FloatArray) -> float:
    return float(np.linalg.norm(found - right) / np.linalg.norm(right))
