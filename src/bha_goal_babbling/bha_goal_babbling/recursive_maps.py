"""The inverse model g(x) as local linear maps fitted by recursive least squares.

    g(x) = sum_k h_k(x) (M_k z_k + v_k),   z_k = (x - p_k) / d_k,
    h_k(x) = exp(-|z_k|^2) / sum_j exp(-|z_j|^2)

The maps are those of `local_linear_map`, each with its own reach d_k. What differs is the step. A
gradient step is as large in a direction that was seen a hundred times as in one that is new; a map
here knows how sure it is of its parameters theta_k = [v_k; M_k] and moves those it is not sure of.
With u_k = [1, z_k] and omega_k = w h_k, covariance C_k shared by all coordinates of the action:

    gain        a_k = C_k u_k / (1 / omega_k + u_k' C_k u_k)
    parameters  theta_k += a_k (q - theta_k' u_k)'
    covariance  C_k <- C_k - a_k (C_k u_k)' + c omega_k I

The first two lines and c = 0 are weighted recursive least squares (Ljung and Soderstrom, "Theory
and practice of recursive identification", 1983; local maps of their own as in Schaal and Atkeson,
"Constructive incremental learning from only local information", 1998), a Kalman filter whose
process noise c keeps it awake. The noise comes with the weight of examples, not with time: what is
not visited is not forgotten.

Maps that are each fitted to the examples around them do not fit them best when blended. Once they
have grown up, the same covariances act on what the blend misses, as one Kalman filter over all
maps whose covariances between maps are left out:

    theta_k += h_k C_k u_k / (1 / w + sum_j h_j^2 u_j' C_j u_j) (q - g(x))'
"""

import dataclasses
import math
from dataclasses import dataclass
from typing import Self

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState

_CHUNK = 1024
"""Outcomes that `predict_many` works on at once; bounds its memory at _CHUNK * K * n numbers."""


@dataclass(frozen=True)
class RecursiveMapsConfig:
    """Settings of `RecursiveMaps`.

    Attributes
    ----------
    distance : float
        Reach d of the first maps, in the unit of outcomes.
    final_distance : float
        What d shrinks to, in the unit of outcomes: after t examples
        d = max(final_distance, distance / sqrt(1 + t / shrink_samples)).
    shrink_samples : float
        Examples within which d begins to shrink.
    covariance : float
        Variance of every parameter of a new map, in units of the variance of an example of weight
        1: how far an example may draw a map away from what its neighbours said.
    covariance_limit : float
        Largest variance of a parameter, in the same unit.
    process_noise : float
        Variance c that an example of weight 1 adds to every parameter, in the same unit.
    blend_samples : float
        Examples after which what the blend misses is learned, instead of what each map misses.
    """

    distance: float = 0.1
    final_distance: float = 0.05
    shrink_samples: float = 500.0
    covariance: float = 4.0
    covariance_limit: float = 10.0
    process_noise: float = 0.15
    blend_samples: float = 1000.0

    def __post_init__(self) -> None:
        for name, value in dataclasses.asdict(self).items():
            if not (math.isfinite(value) and value >= 0) or (
                value == 0 and name not in ("process_noise", "blend_samples")
            ):
                raise InvalidConfigError(f"{name} of recursive maps must be above 0, got {value}")

    def distance_at(self, examples: int) -> float:
        """Return the reach d of maps that are made after a number of examples."""
        shrunk = self.distance / math.sqrt(1.0 + examples / self.shrink_samples)
        return max(self.final_distance, shrunk)


class RecursiveMaps:
    """Local linear maps, each with the covariance of its parameters.

    This is the reference, written in numpy; `CompiledRecursiveMaps` computes the same faster.

    Parameters
    ----------
    config : RecursiveMapsConfig
        All settings.
    outcome : array
        Centre of the first map, shape (n,).
    action : array
        Value of the first map, shape (m,): the model is this constant at first.
    """

    kind = "recursive_maps"

    least_weight = 1e-4
    """Maps with a smaller omega_k are left as they are: they would hardly move."""

    def __init__(
        self, config: RecursiveMapsConfig, outcome: FloatArray, action: FloatArray
    ) -> None:
        n, m = outcome.size, action.size
        self.config = config
        self._count = 0
        self._examples = 0
        # As in LocalLinearMaps: row 0 of a map's parameters is v_k, rows 1 to n the columns of M_k.
        self._centers = np.zeros((16, n))
        self._distances = np.zeros(16)
        self._parameters = np.zeros((16, 1 + n, m))
        self._covariances = np.zeros((16, 1 + n, 1 + n))
        self._append(outcome, np.vstack([action, np.zeros((n, m))]))

    @property
    def count(self) -> int:
        """Number K of maps."""
        return self._count

    @property
    def examples(self) -> int:
        """Number of examples learned."""
        return self._examples

    @property
    def distance(self) -> float:
        """Reach d of a map that is made now."""
        return self.config.distance_at(self._examples)

    @property
    def centers(self) -> FloatArray:
        """Centres p_k, shape (K, n), a copy."""
        return self._centers[: self._count].copy()

    @property
    def distances(self) -> FloatArray:
        """Reaches d_k, shape (K,), a copy."""
        return self._distances[: self._count].copy()

    @property
    def parameters(self) -> FloatArray:
        """Parameters [v_k; M_k'] per d_k of outcome, shape (K, 1 + n, m), a copy."""
        return self._parameters[: self._count].copy()

    @property
    def covariances(self) -> FloatArray:
        """Covariances C_k of [v_k; M_k'], shape (K, 1 + n, 1 + n), a copy."""
        return self._covariances[: self._count].copy()

    def predict(self, outcome: FloatArray) -> FloatArray:
        """Return g at one outcome, shape (n,), as an action, shape (m,)."""
        action: FloatArray = self.predict_many(outcome[np.newaxis])[0]
        return action

    def predict_many(self, outcomes: FloatArray) -> FloatArray:
        """Return g at many outcomes, shape (N, n), as actions, shape (N, m)."""
        rows = [
            self._blend(*self._responsibilities(outcomes[first : first + _CHUNK]))
            for first in range(0, len(outcomes), _CHUNK)
        ]
        return np.concatenate(rows)

    def slope(self, outcome: FloatArray) -> FloatArray:
        """Return the derivative dg/dx at one outcome, shape (n,), as shape (m, n).

        It has two parts: the slopes of the maps, and the change of the responsibilities,
        dh_k/dx = 2 h_k (sum_j h_j z_j / d_j - z_k / d_k).
        """
        z, h = (array[0] for array in self._responsibilities(outcome[np.newaxis]))
        parameters = self._parameters[: self._count]
        distances = self._distances[: self._count, np.newaxis]
        local = parameters[:, 0] + np.einsum("kn,knm->km", z, parameters[:, 1:])
        shift = 2.0 * h[:, np.newaxis] * (h @ (z / distances) - z / distances)
        slope: FloatArray = np.einsum("k,knm->mn", h, parameters[:, 1:] / distances[:, np.newaxis])
        slope += local.T @ shift
        return slope

    def insert(self, outcome: FloatArray) -> None:
        """Add a map at an outcome, shape (n,), that leaves g and dg/dx there as they were."""
        slope = self.distance * self.slope(outcome).T
        self._append(outcome, np.vstack([self.predict(outcome), slope]))

    def learn(self, outcome: FloatArray, action: FloatArray, weight: float) -> None:
        """Insert a map if the outcome lies beyond all others, then correct those around it.

        Parameters
        ----------
        outcome : array
            What was observed, shape (n,).
        action : array
            What was executed and measured, shape (m,).
        weight : float
            Weight w of the example.
        """
        # Insertion comes first, so that the new map has its share of the correction.
        if self._nearest(outcome) > self.distance:
            self.insert(outcome)
        self._correct(outcome, action, weight)
        self._examples += 1

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {
            "centers": self.centers,
            "distances": self.distances,
            "parameters": self.parameters,
            "covariances": self.covariances,
        }
        settings = {"config": dataclasses.asdict(self.config), "examples": self._examples}
        return SavedState(arrays, settings)

    @classmethod
    def restore(cls, state: SavedState) -> Self:
        """Return the maps whose snapshot this is; they continue bit for bit."""
        names = ("centers", "distances", "parameters", "covariances")
        centers, distances, parameters, covariances = (
            np.array(state.arrays[name], dtype=np.float64) for name in names
        )
        count, n = centers.shape
        shapes = (distances.shape, parameters.shape[:2], covariances.shape)
        if shapes != ((count,), (count, 1 + n), (count, 1 + n, 1 + n)) or parameters.ndim != 3:
            raise InvalidConfigError(
                f"centers have shape {centers.shape}, distances {distances.shape}, parameters "
                f"{parameters.shape}, covariances {covariances.shape}: expected (K, n), (K,), "
                "(K, 1 + n, m) and (K, 1 + n, 1 + n)"
            )
        config = RecursiveMapsConfig(**state.settings["config"])
        maps = cls(config, centers[0], parameters[0, 0])
        maps._centers, maps._distances = centers, distances
        maps._parameters, maps._covariances = parameters, covariances
        maps._count, maps._examples = count, int(state.settings["examples"])
        return maps

    def _append(self, outcome: FloatArray, parameters: FloatArray) -> None:
        if self._count == len(self._centers):
            for name in ("_centers", "_distances", "_parameters", "_covariances"):
                array = getattr(self, name)
                setattr(self, name, np.concatenate([array, np.zeros_like(array)]))
        self._centers[self._count] = outcome
        self._distances[self._count] = self.distance
        self._parameters[self._count] = parameters
        self._covariances[self._count] = self.config.covariance * np.eye(1 + outcome.size)
        self._count += 1

    def _nearest(self, outcome: FloatArray) -> float:
        """Return the distance to the nearest centre, in the unit of outcomes."""
        away = self._centers[: self._count] - outcome
        return math.sqrt(float(np.einsum("kn,kn->k", away, away).min()))

    def _responsibilities(self, outcomes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return z_k, shape (N, K, n), and h_k, shape (N, K), at outcomes, shape (N, n)."""
        distances = self._distances[: self._count, np.newaxis]
        z = (outcomes[:, np.newaxis] - self._centers[: self._count]) / distances
        squared = np.einsum("akn,akn->ak", z, z)
        # Without the subtraction every exponential is 0 beyond about 27 d, and h is 0 / 0.
        h = np.exp(squared.min(axis=1, keepdims=True) - squared)
        h /= h.sum(axis=1, keepdims=True)
        return z, h

    def _blend(self, z: FloatArray, h: FloatArray) -> FloatArray:
        parameters = self._parameters[: self._count]
        actions: FloatArray = h @ parameters[:, 0]
        features = (h[:, :, np.newaxis] * z).reshape(len(z), -1)
        actions += features @ parameters[:, 1:].reshape(-1, parameters.shape[2])
        return actions

    def _correct(self, outcome: FloatArray, action: FloatArray, weight: float) -> None:
        """Draw the maps towards one example."""
        z, h = (array[0] for array in self._responsibilities(outcome[np.newaxis]))
        near = np.flatnonzero(weight * h >= self.least_weight)
        if not near.size:
            return
        missed_by_blend = action - self.predict(outcome)
        h = h[near]
        u = np.column_stack([np.ones(near.size), z[near]])
        c_u = np.einsum("kij,kj->ki", self._covariances[near], u)
        u_c_u = np.einsum("ki,ki->k", u, c_u)
        omega = weight * h
        certainty = (1.0 / omega + u_c_u)[:, np.newaxis]
        if self._examples < self.config.blend_samples:
            missed = action - np.einsum("ki,kim->km", u, self._parameters[near])
            self._parameters[near] += (c_u / certainty)[:, :, np.newaxis] * missed[:, np.newaxis]
        else:
            share = h[:, np.newaxis] * c_u / (1.0 / weight + h * h @ u_c_u)
            self._parameters[near] += share[:, :, np.newaxis] * missed_by_blend
        covariances = self._covariances[near]
        covariances -= c_u[:, :, np.newaxis] * c_u[:, np.newaxis] / certainty[:, np.newaxis]
        covariances += (self.config.process_noise * omega)[:, np.newaxis, np.newaxis] * np.eye(
            u.shape[1]
        )
        # Scaled as a whole, so that it stays positive definite.
        largest = np.einsum("kii->ki", covariances).max(axis=1)
        scale = np.minimum(1.0, self.config.covariance_limit / largest)
        self._covariances[near] = scale[:, np.newaxis, np.newaxis] * covariances
