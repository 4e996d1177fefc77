"""What pressure it costs to accelerate the trunk, which couples all bellows.

    p_valves - p_held(l) = B dl/dt + M d2l/dt2

where p_held is what holds the bellows at their lengths as of now, and p_valves follows from the
pressures asked for and the identified lags. Derivatives of noisy lengths are not needed: both sides
go through the same three lags of first order (state variable filters; Young, "Parameter estimation
for continuous-time models - a survey", Automatica 17, 1981), and derivatives of what is filtered
are differences between one lag and the next.

Three alike bellows around the axis make a segment, so bending costs the same whichever way it goes.
The bend of a segment is the complex number z = sqrt(2/3) sum_k l_k exp(2 pi i k / 3), and

    M = Re(T H T'),   T the matrix of z, H Hermitian: one row and column a segment

has 9 unknowns rather than 45, few enough to find what bending the light segments costs, too.

Along its axis a trunk has next to no inertia. What the same fit finds for stretching is what the
valves do beyond a lag of first order; that is no inertia, and bending shows it as well.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from bha_common import bellows
from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics

Array = NDArray[np.float64]

_FILTER_TIME = 0.1  # [s]
_MOVING = 0.01  # [m/s] from which on a tick counts
_LEAST_TICKS = 500  # ten seconds of motion; less tells nothing
_AROUND = np.exp(2j * np.pi * np.arange(bellows.CHAMBERS) / bellows.CHAMBERS)[:, np.newaxis]
_BENDS = np.kron(np.eye(bellows.SEGMENTS), np.sqrt(2.0 / bellows.CHAMBERS) * _AROUND)
_STRETCHES = np.kron(np.eye(bellows.SEGMENTS), np.full_like(_AROUND.real, bellows.CHAMBERS**-0.5))


def fit_inertia(
    lengths: Array, asked: Array, held: Array, dynamics: BellowsDynamics, period: float
) -> Array:
    """Fit the inertia of the trunk's swings to a record of its motion.

    Parameters
    ----------
    lengths : Measured every period [m], shape (n, 9).
    asked : Pressures told in answer to them [Pa], shape (n, 9).
    held : Pressures that hold those lengths as of then [Pa], shape (n, 9).
    dynamics : With its lags identified.
    period : Time between them [s].

    Returns
    -------
    M [Pa s^2/m], shape (9, 9), symmetric, with no eigenvalue below 0; all 0 where the record shows
    too little motion.
    """
    first = _lagged(lengths, period)
    second = _lagged(first, period)
    third = _lagged(second, period)
    speeds = (second - third) / _FILTER_TIME
    accelerations = (first - 2.0 * second + third) / _FILTER_TIME**2
    left = through_valves(asked, dynamics, period) - held
    for _ in range(3):
        left = _lagged(left, period)
    moving = np.abs(speeds).max(axis=1) > _MOVING
    if np.count_nonzero(moving) < _LEAST_TICKS:
        return np.zeros((bellows.COUNT, bellows.COUNT))
    bending, stretching = (
        _cost(left[moving] @ parts, accelerations[moving] @ parts, speeds[moving] @ parts)
        for parts in (_BENDS, _STRETCHES)
    )
    values, vectors = np.linalg.eigh(0.5 * (bending + bending.conj().T))
    values = np.maximum(values - stretching.diagonal().mean(), 0.0)
    swings = _BENDS @ vectors
    inertia: Array = ((swings * values) @ swings.conj().T).real
    return inertia


def _cost(left: Any, accelerations: Any, speeds: Any) -> Any:
    """Fit what accelerating a bend or stretch of each segment costs, shape (3, 3)."""
    known = np.hstack([accelerations, speeds, np.ones((len(left), 1))])
    return np.linalg.lstsq(known, left, rcond=None)[0][: bellows.SEGMENTS]


def through_valves(asked: Array, dynamics: BellowsDynamics, period: float) -> Array:
    """Tell pressures in the bellows [Pa], (n, 9), by those asked for in answer to each reading.

    As they are at each reading, when the answer to it has not acted yet; at rest at the first.
    """
    waits = 1 + round(dynamics.dead_time / period)
    late = np.vstack([np.repeat(asked[:1], waits, axis=0), asked])[: len(asked)]
    fill, vent = (
        -np.expm1(-period / lag) if lag > 0.0 else 1.0
        for lag in (dynamics.fill_lag, dynamics.vent_lag)
    )
    inside, now = np.empty_like(asked), asked[0]
    for k, target in enumerate(late):
        away = target - now
        now = now + np.where(away > 0.0, fill, vent) * away
        inside[k] = now
    return inside


def _lagged(values: Array, period: float) -> Array:
    """Return values (n, 9) after a lag of first order that begins at rest at the first."""
    # Bilinear, so that (x - lag of x) / time is the derivative of the lag at these frequencies.
    share = period / (2.0 * _FILTER_TIME + period)
    stay = 1.0 - 2.0 * share
    start = (1.0 - share) * values[:1]
    filtered, _ = lfilter([share, share], [1.0, -stay], values, axis=0, zi=start)
    result: Array = filtered
    return result
