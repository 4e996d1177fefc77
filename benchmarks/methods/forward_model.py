"""A learned forward model f(q): Bayesian linear regression on random features, one by one.

Recursive least squares (Ljung, "System identification", 1999, section 11.2): after every example
the estimate is that of ridge regression on all examples so far.
"""

import numpy as np

from benchmarks.methods.random_features import RandomFeatures
from bha_goal_babbling.arrays import FloatArray


class ForwardModel:
    """Predicts outcomes of actions, and the Jacobian.

    Parameters
    ----------
    home_action, home_outcome : array
        What it knows at first, shapes (m,) and (n,): every action ends at the home outcome.
    length : float
        Length of the features [action unit].
    waves : int
        Number of random features.
    noise : float
        Ratio of the standard deviations of what the features miss and of the parameters.
    rng : numpy.random.Generator
        Source of the features.
    """

    def __init__(
        self,
        home_action: FloatArray,
        home_outcome: FloatArray,
        length: float,
        waves: int,
        noise: float,
        rng: np.random.Generator,
    ) -> None:
        self._features = RandomFeatures(home_action, length, waves, rng)
        self._parameters = np.zeros((self._features.count, home_outcome.size))
        self._parameters[0] = home_outcome
        self._covariance = np.eye(self._features.count) / noise**2

    def learn(self, action: FloatArray, outcome: FloatArray) -> None:
        """Take one example, shapes (m,) and (n,)."""
        features = self._features(action[np.newaxis])[0]
        spread = self._covariance @ features
        gain = spread / (1.0 + features @ spread)
        self._parameters += np.outer(gain, outcome - features @ self._parameters)
        self._covariance -= np.outer(gain, spread)

    def predict(self, actions: FloatArray) -> FloatArray:
        """Return the outcomes of actions, shape (N, m), as shape (N, n)."""
        outcomes: FloatArray = self._features(actions) @ self._parameters
        return outcomes

    def jacobian(self, actions: FloatArray) -> FloatArray:
        """Return the derivative of outcomes by actions, shape (N, m), as shape (N, n, m)."""
        return self._features.slopes(actions, self._parameters)
