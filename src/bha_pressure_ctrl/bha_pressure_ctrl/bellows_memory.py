"""What bellows remember of where they were, and what pressure that costs.

A bellows of polyamide creeps, and it has friction, so the pressure that holds a length depends on
the lengths before. Two families of states tell them, each of one bellows by itself:

- creep, for a few times T: the distance of the length from a lag of it, l - c, dc/dt = (l - c) / T
  (the branches of a generalised Maxwell solid);
- friction, for a few widths r: s = clip(s + dl, -r, r), the stop operator of Prandtl and
  Ishlinskii.

Kuhnen ("Modeling, identification and compensation of complex hysteretic nonlinearities", European
Journal of Control 9, 2003) makes up for creep and hysteresis in a feed-forward as it is done here.

The pressure is linear in them, so weights are fitted by least squares. Times and widths form a
grid coarse enough for any such robot and are not fitted: a weight that is not needed comes out as
small.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows

Array = NDArray[np.float64]

CREEP_TIMES = np.array([2.0, 10.0, 60.0])
"""Times of the creep [s]; what takes longer, the integral and the age of the model stand for."""

FRICTION_WIDTHS = np.array([1.5e-3, 5e-3])
"""Widths of the friction [m]."""

STATES = len(CREEP_TIMES) + len(FRICTION_WIDTHS)
"""Number of states of a bellows."""

_FRICTION_KEPT = 0.5
"""Share of the friction found in identification that is left in control; so on ten robots."""

# Relative to the variance of a length: of the affine part, square and cube, states, and the drift.
_PENALTIES = np.repeat([1e-4, 1e-3, 1e-4], [bellows.COUNT + 2, STATES, 1])


class BellowsMemory:
    """The states of nine bellows, for lengths told every period.

    Parameters
    ----------
    lengths : Lengths at which they have rested [m], shape (9,).
    period : Time between two updates [s].
    """

    def __init__(self, lengths: Array, period: float) -> None:
        self._lengths = lengths
        self._shares = -np.expm1(-period / CREEP_TIMES)[:, None]
        self._widths = FRICTION_WIDTHS[:, None]
        self._crept = np.tile(lengths, (len(CREEP_TIMES), 1))
        self._states = np.zeros((STATES, bellows.COUNT))

    def update(self, lengths: Array) -> Array:
        """Advance by one period; return the states [m], shape (STATES, 9)."""
        creeps = len(CREEP_TIMES)
        away = lengths - self._crept
        self._crept += self._shares * away
        states = np.empty((STATES, bellows.COUNT))
        np.subtract(lengths, self._crept, out=states[:creeps])
        moved = self._states[creeps:] + (lengths - self._lengths)
        np.minimum(np.maximum(moved, -self._widths, out=moved), self._widths, out=states[creeps:])
        self._lengths, self._states = lengths, states
        return states


def fit_memory(lengths: Array, pressures: Array, states: Array, times: Array) -> Array:
    """Fit what pressure the states cost, beside what the lengths themselves do.

    The lengths are taken to act affinely, and each on its own pressure in its square and cube too;
    a better map of them may be fitted afterwards to what is left of the pressures.

    Parameters
    ----------
    lengths : [m], shape (n, 9), at rest or nearly.
    pressures : That were applied then [Pa], shape (n, 9).
    states : Of `BellowsMemory` [m], shape (n, STATES, 9).
    times : When that was [s], shape (n,); the pressures are taken to drift evenly in time.

    Returns
    -------
    Pressure per state [Pa/m], shape (STATES, 9). None is below 0: creep and friction resist.
    """
    scale = lengths.std(axis=0).mean()
    x = (lengths - lengths.mean(axis=0)) / scale
    span = max(float(np.ptp(times)), 1.0)
    weights = np.empty((STATES, bellows.COUNT))
    for k in range(bellows.COUNT):
        own = x[:, k : k + 1]
        columns = [x, own**2, own**3, states[:, :, k] / scale, times[:, None] / span]
        features = np.hstack(columns)
        features = features - features.mean(axis=0)
        gram = features.T @ features + len(x) * np.diag(_PENALTIES)
        fitted = np.linalg.solve(gram, features.T @ (pressures[:, k] - pressures[:, k].mean()))
        weights[:, k] = np.maximum(fitted[-1 - STATES : -1], 0.0) / scale
    return weights


def friction_in_control(weights: Array) -> Array:
    """Take from fitted weights, shape (STATES, 9), the friction that control does not meet.

    While samples are taken, pressures come from one side and stand still: what regulators leave of
    a step (their dead band) looks like friction. In control pressures turn back as soon as the
    lengths have come, to make up for creep, and that part is gone.
    """
    kept = np.ones((STATES, 1))
    kept[len(CREEP_TIMES) :] = _FRICTION_KEPT
    in_control: Array = kept * weights
    return in_control
