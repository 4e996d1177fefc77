"""A direct inverse model with fixed features: the same local linear maps, laid out beforehand.

    g(x) = q_home + sum_k h_k(x) [1, z_k] theta_k,   z_k = (x - p_k) / d

with responsibilities h_k as in the local linear maps of goal babbling, and centres p_k on a grid
over the goals. Methods whose subject is not where maps are needed share it, so that what is
compared is how they learn.
"""

import itertools

import numpy as np

from bha_goal_babbling.arrays import FloatArray


class GoalFeatures:
    """Features h_k [1, z_k] of outcomes.

    Parameters
    ----------
    goals : array
        Goals whose bounding box is covered, shape (G, n) [outcome unit].
    distance : float
        Spacing and reach d of the maps [outcome unit].
    """

    def __init__(self, goals: FloatArray, distance: float) -> None:
        axes = [
            np.linspace(low, high, max(2, round((high - low) / distance) + 1))
            for low, high in zip(goals.min(axis=0), goals.max(axis=0), strict=True)
        ]
        self._centers = np.array(list(itertools.product(*axes)))
        self._distance = distance
        self.count = self._centers.size + len(self._centers)

    def __call__(self, outcomes: FloatArray) -> FloatArray:
        """Return the features of outcomes, shape (N, n), as shape (N, K (1 + n))."""
        z = (outcomes[:, np.newaxis] - self._centers) / self._distance
        squared = np.einsum("akn,akn->ak", z, z)
        h = np.exp(squared.min(axis=1, keepdims=True) - squared)
        h /= h.sum(axis=1, keepdims=True)
        features = h[:, :, np.newaxis] * np.concatenate([np.ones_like(z[:, :, :1]), z], axis=2)
        return features.reshape(len(outcomes), -1)


class GoalModel:
    """The inverse model on these features; it answers with home until it is changed.

    Parameters
    ----------
    goals, distance :
        See `GoalFeatures`.
    home_action : array
        Shape (m,) [action unit].
    """

    def __init__(self, goals: FloatArray, distance: float, home_action: FloatArray) -> None:
        self.features = GoalFeatures(goals, distance)
        self.parameters = np.zeros((self.features.count, home_action.size))
        self._home_action = home_action

    def __call__(self, outcomes: FloatArray) -> FloatArray:
        """Return g at outcomes, shape (N, n), as shape (N, m)."""
        actions: FloatArray = self._home_action + self.features(outcomes) @ self.parameters
        return actions

    def change(self, outcome: FloatArray, action_step: FloatArray, rate: float) -> None:
        """Move g at one outcome, shape (n,), by `rate` times an action step, shape (m,).

        A step along the gradient of the parameters, divided by the squared length of the features
        (normalised least mean squares), so that a rate of 1 goes the whole way.
        """
        features = self.features(outcome[np.newaxis])[0]
        self.parameters += np.outer(rate / (features @ features) * features, action_step)
