"""The inverse model g(x): local linear maps, blended by normalised Gaussian responsibilities.

    g(x) = sum_k h_k(x) (M_k z_k + v_k),   z_k = (x - p_k) / d,
    h_k(x) = exp(-|z_k|^2) / sum_j exp(-|z_j|^2)

A map has its centre p_k, its value v_k and its slope M_k. New maps appear where outcomes are
observed; values and slopes follow the weighted gradient of |q - g(x)|^2 (Rolf, Steil and Gienger,
"Online goal babbling for rapid bootstrapping of inverse models in high dimensions", 2011).
"""

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState

_CHUNK = 1024
"""Outcomes that `predict_many` works on at once; bounds its memory at _CHUNK * K * n numbers."""


class LocalLinearMaps:
    """Local linear maps with a gradient step.

    Parameters
    ----------
    distance : float
        Reach d of a map, in the unit of outcomes. A new map is made where the nearest is farther.
    learning_rate : float
        Step eta of the gradient.
    outcome : array
        Centre of the first map, shape (n,).
    action : array
        Value of the first map, shape (m,): the model is this constant at first.
    """

    kind = "local_linear_maps"

    def __init__(
        self, distance: float, learning_rate: float, outcome: FloatArray, action: FloatArray
    ) -> None:
        if not (distance > 0 and learning_rate > 0):
            raise InvalidConfigError(
                f"distance and learning_rate must be above 0, got {distance} and {learning_rate}"
            )
        self._distance = float(distance)
        self._rate = float(learning_rate)
        n, m = outcome.size, action.size
        self._count = 1
        # Row 0 of a map's parameters is v_k, rows 1 to n are the columns of M_k: then
        # g(x) = sum_k h_k [1, z_k] parameters_k, and value and slope share one update.
        self._centers = np.zeros((16, n))
        self._parameters = np.zeros((16, 1 + n, m))
        self._centers[0] = outcome
        self._parameters[0, 0] = action

    @property
    def count(self) -> int:
        """Number K of maps."""
        return self._count

    @property
    def centers(self) -> FloatArray:
        """Centres p_k, shape (K, n), a copy."""
        return self._centers[: self._count].copy()

    @property
    def values(self) -> FloatArray:
        """Values v_k, shape (K, m), a copy."""
        return self._parameters[: self._count, 0].copy()

    @property
    def slopes(self) -> FloatArray:
        """Slopes M_k per d of outcome, shape (K, m, n), a copy."""
        return self._parameters[: self._count, 1:].transpose(0, 2, 1).copy()

    def predict(self, outcome: FloatArray) -> FloatArray:
        """Return g at one outcome, shape (n,), as an action, shape (m,)."""
        features, _ = self._features(outcome)
        return self._blend(features)

    def predict_many(self, outcomes: FloatArray) -> FloatArray:
        """Return g at many outcomes, shape (N, n), as actions, shape (N, m)."""
        rows = [
            self._blend_many(outcomes[first : first + _CHUNK])
            for first in range(0, len(outcomes), _CHUNK)
        ]
        return np.concatenate(rows)

    def slope(self, outcome: FloatArray) -> FloatArray:
        """Return the derivative dg/dx at one outcome, shape (n,), as shape (m, n).

        It has two parts: the slopes of the maps, and the change of the responsibilities,
        dh_k/dx = 2 h_k (sum_j h_j z_j - z_k) / d.
        """
        return self._scaled_slope(outcome).T / self._distance

    def insert(self, outcome: FloatArray) -> None:
        """Add a map at an outcome, shape (n,), that leaves g and dg/dx there as they were."""
        value = self.predict(outcome)
        slope = self._scaled_slope(outcome)
        if self._count == len(self._centers):
            self._centers = np.concatenate([self._centers, np.zeros_like(self._centers)])
            self._parameters = np.concatenate([self._parameters, np.zeros_like(self._parameters)])
        self._centers[self._count] = outcome
        self._parameters[self._count, 0] = value
        self._parameters[self._count, 1:] = slope
        self._count += 1

    def learn(self, outcome: FloatArray, action: FloatArray, weight: float) -> None:
        """Insert a map if the outcome lies beyond all others, then take one gradient step.

        v_k += eta w h_k (q - g(x));  M_k += eta w h_k (q - g(x)) z_k'

        Parameters
        ----------
        outcome : array
            What was observed, shape (n,).
        action : array
            What was executed and measured, shape (m,).
        weight : float
            Weight w of the example.
        """
        features, nearest = self._features(outcome)
        # Insertion comes first, so that the new map has its share of the step.
        if nearest > 1.0:
            self.insert(outcome)
            features, _ = self._features(outcome)
        residual = action - self._blend(features)
        step = (self._rate * weight) * features
        self._parameters[: self._count] += step[:, :, np.newaxis] * residual

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {
            "centers": self._centers[: self._count].copy(),
            "parameters": self._parameters[: self._count].copy(),
        }
        return SavedState(arrays, {"distance": self._distance, "learning_rate": self._rate})

    @classmethod
    def restore(cls, state: SavedState) -> "LocalLinearMaps":
        """Return the maps whose snapshot this is; they continue bit for bit."""
        centers, parameters = state.arrays["centers"], state.arrays["parameters"]
        maps = cls(
            state.settings["distance"],
            state.settings["learning_rate"],
            centers[0],
            parameters[0, 0],
        )
        if parameters.shape[:2] != (len(centers), centers.shape[1] + 1):
            raise InvalidConfigError(
                f"parameters have shape {parameters.shape}, centers {centers.shape}: "
                "expected (K, 1 + n, m) and (K, n)"
            )
        maps._centers, maps._parameters = centers.copy(), parameters.copy()
        maps._count = len(centers)
        return maps

    def _features(self, outcome: FloatArray) -> tuple[FloatArray, float]:
        """Return h_k [1, z_k], shape (K, 1 + n), and the smallest |z_k|^2."""
        z = (outcome - self._centers[: self._count]) / self._distance
        squared = np.einsum("kn,kn->k", z, z)
        nearest = float(squared.min())
        # Without the subtraction every exponential is 0 beyond about 27 d, and h is 0 / 0.
        h = np.exp(nearest - squared)
        h /= h.sum()
        features = np.empty((self._count, 1 + z.shape[1]))
        features[:, 0] = h
        np.multiply(h[:, np.newaxis], z, out=features[:, 1:])
        return features, nearest

    def _blend(self, features: FloatArray) -> FloatArray:
        parameters = self._parameters[: self._count]
        action: FloatArray = features.reshape(-1) @ parameters.reshape(-1, parameters.shape[2])
        return action

    def _blend_many(self, outcomes: FloatArray) -> FloatArray:
        z = (outcomes[:, np.newaxis] - self._centers[: self._count]) / self._distance
        squared = np.einsum("akn,akn->ak", z, z)
        h = np.exp(squared.min(axis=1, keepdims=True) - squared)
        h /= h.sum(axis=1, keepdims=True)
        features = h[:, :, np.newaxis] * np.concatenate([np.ones_like(z[:, :, :1]), z], axis=2)
        parameters = self._parameters[: self._count]
        flat = parameters.reshape(-1, parameters.shape[2])
        actions: FloatArray = features.reshape(len(outcomes), -1) @ flat
        return actions

    def _scaled_slope(self, outcome: FloatArray) -> FloatArray:
        """Return d times dg/dx, transposed: shape (n, m)."""
        features, _ = self._features(outcome)
        h = features[:, 0]
        z = (outcome - self._centers[: self._count]) / self._distance
        parameters = self._parameters[: self._count]
        local = parameters[:, 0] + np.einsum("kn,knm->km", z, parameters[:, 1:])
        shift = 2.0 * h[:, np.newaxis] * (h @ z - z)
        slope: FloatArray = np.einsum("k,knm->nm", h, parameters[:, 1:]) + shift.T @ local
        return slope
