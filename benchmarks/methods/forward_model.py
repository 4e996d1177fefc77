"""A learned forward model f(q): ridge regression on random features.

    parameters = (Phi' Phi + noise^2 I)^-1 Phi' dx = Phi' (Phi Phi' + noise^2 I)^-1 dx,
    dx = x - x_home,

over all examples so far; the second form is the cheaper one while there are fewer examples than
features. A fit costs the cube of the smaller number, so examples are gathered and fitted when the
model is asked and their number has grown enough.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from benchmarks.methods.inverse_jacobian import follow_lines
from benchmarks.methods.random_features import RandomFeatures
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray

_GROWTH = 0.05
"""Share by which the examples must have become more for a new fit."""


@dataclass(frozen=True)
class ForwardModelSettings:
    """Settings of a forward model.

    Attributes
    ----------
    length : float
        Length over which outcomes change with one coordinate of the action [action unit].
    waves : int
        Number of random features.
    noise : float
        Ratio of the standard deviations of what the features miss and of the parameters.
    """

    length: float = 1.0
    waves: int = 600
    noise: float = 1e-3


USUAL = ForwardModelSettings()
"""The settings of methods that are given none."""


class ForwardModel:
    """Predicts outcomes of actions, and the Jacobian.

    Parameters
    ----------
    home_action, home_outcome : array
        What it knows at first, shapes (m,) and (n,): every action ends at the home outcome.
    settings : ForwardModelSettings
        Its features and how closely they are fitted.
    rng : numpy.random.Generator
        Source of the features.
    """

    def __init__(
        self,
        home_action: FloatArray,
        home_outcome: FloatArray,
        settings: ForwardModelSettings,
        rng: np.random.Generator,
    ) -> None:
        # Distances in m dimensions grow with the root of m, and so must the features' length.
        length = settings.length * np.sqrt(home_action.size)
        self._features = RandomFeatures(home_action, length, settings.waves, rng)
        self._home_outcome = home_outcome
        self._ridge = settings.noise**2
        self._square = self._ridge * np.eye(self._features.count)
        self._product = np.zeros((self._features.count, home_outcome.size))
        self._parameters = np.zeros_like(self._product)
        self._actions: list[FloatArray] = []
        self._outcomes: list[FloatArray] = []
        self._fitted = 0
        # All examples, as long as they are fewer than the features.
        self._rows = np.empty((0, self._features.count))
        self._misses = np.empty((0, home_outcome.size))

    def learn(self, action: FloatArray, outcome: FloatArray) -> None:
        """Take one example, shapes (m,) and (n,)."""
        self._actions.append(action)
        self._outcomes.append(outcome)

    def predict(self, actions: FloatArray) -> FloatArray:
        """Return the outcomes of actions, shape (N, m), as shape (N, n)."""
        self._fit()
        outcomes: FloatArray = self._home_outcome + self._features(actions) @ self._parameters
        return outcomes

    def jacobian(self, actions: FloatArray) -> FloatArray:
        """Return the derivative of outcomes by actions, shape (N, m), as shape (N, n, m)."""
        self._fit()
        return self._features.slopes(actions, self._parameters)

    def reach(self, goals: FloatArray, world: World, home_pull: float) -> FloatArray:
        """Return actions, shape (G, m), that reach goals, shape (G, n), as far as it knows.

        They lie within the limits of the world; the pull is that of `follow_lines`.
        """
        return follow_lines(
            self.predict,
            self.jacobian,
            world.clipped,
            world.home_action,
            goals,
            home_pull=home_pull,
        )

    def _fit(self) -> None:
        if len(self._actions) <= _GROWTH * self._fitted:
            return
        rows = self._features(np.array(self._actions))
        misses = np.array(self._outcomes) - self._home_outcome
        self._square += rows.T @ rows
        self._product += rows.T @ misses
        self._fitted += len(self._actions)
        self._actions, self._outcomes = [], []
        if self._fitted < self._features.count:
            self._rows = np.concatenate([self._rows, rows])
            self._misses = np.concatenate([self._misses, misses])
            gram = self._rows @ self._rows.T + self._ridge * np.eye(self._fitted)
            self._parameters = self._rows.T @ cho_solve(cho_factor(gram), self._misses)
        else:
            self._parameters = cho_solve(cho_factor(self._square), self._product)
