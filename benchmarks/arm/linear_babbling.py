"""Goal babbling on random linear problems, x = F q, with one map as a linear estimate."""

import math
from collections.abc import Sequence

import numpy as np

from benchmarks.engine.experiment import Figures
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.local_linear_map import LocalLinearMaps
from bha_goal_babbling.saved_state import SavedState

OUTCOMES = 2
"""Number n of coordinates of an outcome."""

_ACTIONS = 4
_VALUE_RATE = 0.3  # eta of the value of the one map
_PATH_STEPS = 5
_CURVE_POINTS = 60


def target_variance() -> float:
    """Return the variance of a coordinate of the targets along the paths between goals.

    A coordinate of the goals is one of -1, -1/2, 0, 1/2, 1: variance 1/2; on the way from one to
    the next the two ends mix.
    """
    mixed = np.arange(1, _PATH_STEPS + 1) / _PATH_STEPS
    return 0.5 * float(np.mean(mixed**2 + (1.0 - mixed) ** 2))


def learn(
    rng: np.random.Generator,
    weights: str,
    spread: float,
    rates: Sequence[float],
    samples: Sequence[int],
) -> Figures:
    """Return how far goal babbling is from reaching, and from the pseudo-inverse, as it learns.

    With a slope G = dg/dx, the unreached share is |1 - F G| / |1|, and the distance is
    |G - F^+| / |F^+|.

    Parameters
    ----------
    rng : numpy.random.Generator
        Source of the problem and of all randomness in learning.
    weights : str
        "plain" or "none", for w_dir and w_eff both.
    spread : float
        Noise s.
    rates, samples : sequences
        Learning rates of the slope, one after the other, and for how many samples each.
    """
    forward = np.linalg.qr(rng.standard_normal((_ACTIONS, OUTCOMES)))[0].T
    best = np.linalg.pinv(forward)
    axis = np.linspace(-1.0, 1.0, 5)
    goals = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, OUTCOMES)
    home, start, limits = np.zeros(_ACTIONS), np.zeros(OUTCOMES), np.full(_ACTIONS, 1e3)
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
            unreached.append(_relative(forward @ slope, np.eye(OUTCOMES)))
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
