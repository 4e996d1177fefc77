"""The maps of `recursive_maps`, compiled: the same numbers to a rounding, many times faster.

What runs at every sample are two loops over the maps: one finds the responsibilities, the other
works on the few maps that have any. A map whose responsibility is below the rounding of the
largest is left out of sums. The machine code is cached on disk, so only the first start compiles.
"""

import math

import numba
import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.recursive_maps import RecursiveMaps

_NEGLIGIBLE = 38.0
"""|z_k|^2 above the smallest from where exp(-...) is below 1e-16, the rounding of a sum."""


class CompiledRecursiveMaps(RecursiveMaps):
    """`RecursiveMaps` whose prediction and correction are compiled."""

    def predict(self, outcome: FloatArray) -> FloatArray:
        """Return g at one outcome, shape (n,), as an action, shape (m,)."""
        action = np.empty(self._parameters.shape[2])
        h = np.empty(self._count)
        _predict(outcome, self._centers, self._distances, self._parameters, h, action)
        return action

    def predict_many(self, outcomes: FloatArray) -> FloatArray:
        """Return g at many outcomes, shape (N, n), as actions, shape (N, m)."""
        actions = np.empty((len(outcomes), self._parameters.shape[2]))
        h = np.empty(self._count)
        _predict_many(outcomes, self._centers, self._distances, self._parameters, h, actions)
        return actions

    def _nearest(self, outcome: FloatArray) -> float:
        nearest: float = _nearest(outcome, self._centers, self._count)
        return nearest

    def _correct(self, outcome: FloatArray, action: FloatArray, weight: float) -> None:
        _correct(
            outcome,
            action,
            weight,
            self._centers,
            self._distances,
            self._parameters,
            self._covariances,
            np.empty(self._count),
            self._examples >= self.config.blend_samples,
            self.config.process_noise,
            self.config.covariance_limit,
            self.least_weight,
        )


@numba.njit(cache=True)
def _nearest(outcome: FloatArray, centers: FloatArray, count: int) -> float:
    """Return the distance to the nearest of the first centres."""
    smallest = np.inf
    for k in range(count):
        squared = 0.0
        for i in range(outcome.size):
            squared += (outcome[i] - centers[k, i]) ** 2
        smallest = min(smallest, squared)
    return math.sqrt(smallest)


@numba.njit(cache=True)
def _responsibilities(
    outcome: FloatArray, centers: FloatArray, distances: FloatArray, h: FloatArray
) -> None:
    """Write h_k at an outcome, shape (n,), to h, shape (K,); exactly 0 where it is negligible."""
    smallest = np.inf
    for k in range(h.size):
        squared = 0.0
        for i in range(outcome.size):
            squared += ((outcome[i] - centers[k, i]) / distances[k]) ** 2
        h[k] = squared
        smallest = min(smallest, squared)
    total = 0.0
    for k in range(h.size):
        beyond = h[k] - smallest
        h[k] = math.exp(-beyond) if beyond < _NEGLIGIBLE else 0.0
        total += h[k]
    for k in range(h.size):
        h[k] /= total


@numba.njit(cache=True)
def _predict(
    outcome: FloatArray,
    centers: FloatArray,
    distances: FloatArray,
    parameters: FloatArray,
    h: FloatArray,
    action: FloatArray,
) -> None:
    """Write g at an outcome, shape (n,), to action, shape (m,), and h_k to h, shape (K,)."""
    _responsibilities(outcome, centers, distances, h)
    action[:] = 0.0
    for k in range(h.size):
        if h[k] == 0.0:
            continue
        for j in range(action.size):
            action[j] += h[k] * parameters[k, 0, j]
        for i in range(outcome.size):
            share = h[k] * (outcome[i] - centers[k, i]) / distances[k]
            for j in range(action.size):
                action[j] += share * parameters[k, 1 + i, j]


@numba.njit(cache=True)
def _predict_many(
    outcomes: FloatArray,
    centers: FloatArray,
    distances: FloatArray,
    parameters: FloatArray,
    h: FloatArray,
    actions: FloatArray,
) -> None:
    """Write g at outcomes, shape (N, n), to actions, shape (N, m)."""
    for row in range(len(outcomes)):
        _predict(outcomes[row], centers, distances, parameters, h, actions[row])


@numba.njit(cache=True)
def _correct(
    outcome: FloatArray,
    action: FloatArray,
    weight: float,
    centers: FloatArray,
    distances: FloatArray,
    parameters: FloatArray,
    covariances: FloatArray,
    h: FloatArray,
    blended: bool,
    process_noise: float,
    limit: float,
    least_weight: float,
) -> None:
    """Draw the maps towards one example, as `RecursiveMaps._correct` does."""
    n, m = outcome.size, action.size
    blend = np.empty(m)
    _predict(outcome, centers, distances, parameters, h, blend)
    near = np.flatnonzero(weight * h >= least_weight)
    u = np.ones((near.size, 1 + n))
    c_u = np.zeros((near.size, 1 + n))
    u_c_u = np.zeros(near.size)
    variance = 0.0
    for a in range(near.size):
        k = near[a]
        for i in range(n):
            u[a, 1 + i] = (outcome[i] - centers[k, i]) / distances[k]
        for i in range(1 + n):
            for j in range(1 + n):
                c_u[a, i] += covariances[k, i, j] * u[a, j]
            u_c_u[a] += u[a, i] * c_u[a, i]
        variance += h[k] * h[k] * u_c_u[a]
    for a in range(near.size):
        k = near[a]
        omega = weight * h[k]
        certainty = 1.0 / omega + u_c_u[a]
        for j in range(m):
            if blended:
                step = (action[j] - blend[j]) * h[k] / (1.0 / weight + variance)
            else:
                missed = action[j]
                for i in range(1 + n):
                    missed -= u[a, i] * parameters[k, i, j]
                step = missed / certainty
            for i in range(1 + n):
                parameters[k, i, j] += c_u[a, i] * step
        largest = 0.0
        for i in range(1 + n):
            for j in range(1 + n):
                covariances[k, i, j] -= c_u[a, i] * c_u[a, j] / certainty
            covariances[k, i, i] += process_noise * omega
            largest = max(largest, covariances[k, i, i])
        if largest > limit:
            for i in range(1 + n):
                for j in range(1 + n):
                    covariances[k, i, j] *= limit / largest
