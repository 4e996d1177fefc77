"""Direct fit on random data: regression of actions on outcomes of motor babbling.

What section 1 of the article warns of: where many actions have the same outcome the fit answers
with their average, which is in general not one of them.
"""

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from benchmarks.methods.goal_features import GoalFeatures
from benchmarks.methods.method import Method
from benchmarks.methods.motor_babbling import random_action
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray


class DirectFit(Method):
    """Random actions, and ridge regression of x -> q on local linear features.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of the actions.
    spread : float
        Largest distance from home of every coordinate of an action [action unit].
    distance : float
        Spacing of the features [outcome unit].
    ridge : float
        Weight of the home action against one example.
    """

    def __init__(
        self,
        world: World,
        rng: np.random.Generator,
        *,
        spread: float = 0.5,
        distance: float = 0.2,
        ridge: float = 0.01,
    ) -> None:
        super().__init__(world)
        self._rng = rng
        self._spread = spread
        self._features = GoalFeatures(world.goals, distance)
        self._square = ridge * np.eye(self._features.count)
        self._product = np.zeros((self._features.count, world.home_action.size))

    def step(self) -> None:
        """Execute a random action and add it to the normal equations."""
        action = random_action(self.world, self._spread, self._rng)
        features = self._features(self.world.execute(action)[np.newaxis])
        self._square += features.T @ features
        self._product += features.T @ (action - self.world.home_action)[np.newaxis]

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return the fitted actions; see `Method`."""
        parameters = cho_solve(cho_factor(self._square), self._product)
        return self.world.clipped(self.world.home_action + self._features(goals) @ parameters)
