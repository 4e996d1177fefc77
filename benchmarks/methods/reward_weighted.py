"""Reward-weighted regression: the policy is fitted to its own trials, the good ones counting more.

    q ~ N(g(x*), S),   u = exp(-b |x - x*|^2),   (g, S) <- weighted maximum likelihood
    b <- sum u / sum u |x - x*|^2

An expectation-maximisation step on the expected reward, with the reward's sharpness b adapted
(Peters and Schaal, "Reinforcement learning by reward-weighted regression for operational space
control", 2007). Here a trial is one reach: context x*, action q.
"""

import numpy as np
from scipy.linalg import solve

from benchmarks.methods.goal_features import GoalModel
from benchmarks.methods.method import Method
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray


def weighted_change(
    features: FloatArray, residuals: FloatArray, weights: FloatArray, ridge: float
) -> FloatArray:
    """Return the parameters' change: weighted least squares, with a ridge towards no change.

    Parameters
    ----------
    features : array
        Shape (N, F).
    residuals : array
        Actions less what the policy said, shape (N, m).
    weights : array
        Shape (N,).
    ridge : float
        Weight of the old parameters.

    Returns
    -------
    array
        Shape (F, m).
    """
    weighted = weights[:, np.newaxis] * features
    square = weighted.T @ features + ridge * np.eye(features.shape[1])
    change: FloatArray = solve(square, weighted.T @ residuals, assume_a="pos")
    return change


class RewardWeightedRegression(Method):
    """Reaches goals of the set at random; now and then fits the policy to the last trials.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of goals and noise.
    exploration : float
        Standard deviation of the policy at first [action unit].
    smallest_exploration : float
        The policy's standard deviation does not fall below this [action unit].
    batch : int
        Trials between two fits.
    window : int
        Number of last trials that a fit uses.
    ridge : float
        Weight of the old policy in a fit.
    distance : float
        Spacing of the policy's features [outcome unit].
    """

    def __init__(
        self,
        world: World,
        rng: np.random.Generator,
        *,
        exploration: float = 0.1,
        smallest_exploration: float = 0.01,
        batch: int = 50,
        window: int = 200,
        ridge: float = 0.01,
        distance: float = 0.2,
    ) -> None:
        super().__init__(world)
        self._rng = rng
        self._exploration = exploration
        self._smallest_exploration = smallest_exploration
        self._batch = batch
        self._window = window
        self._ridge = ridge
        self._policy = GoalModel(world.goals, distance, world.home_action)
        self._trials: list[tuple[FloatArray, FloatArray, FloatArray]] = []
        self._sharpness = 0.0

    def step(self) -> None:
        """Reach for one goal; fit the policy when a batch is full."""
        goal = self.world.goals[self._rng.integers(len(self.world.goals))]
        noise = self._exploration * self._rng.standard_normal(self.world.home_action.size)
        action = self.world.clipped(self._policy(goal[np.newaxis])[0] + noise)
        self._trials.append((goal, action, self.world.execute(action)))
        if len(self._trials) % self._batch == 0:
            self._fit()

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return the policy's mean; see `Method`."""
        return self.world.clipped(self._policy(goals))

    def _fit(self) -> None:
        self._trials = self._trials[-self._window :]
        goals, actions, outcomes = (np.array(part) for part in zip(*self._trials, strict=True))
        costs = np.square(outcomes - goals).sum(axis=1)
        if self._sharpness == 0.0:
            self._sharpness = 1.0 / costs.mean()
        # The best trial gets weight 1: a common factor changes no fit but may underflow.
        weights = np.exp(-self._sharpness * (costs - costs.min()))
        self._sharpness = weights.sum() / (weights @ costs)
        residuals = actions - self._policy(goals)
        features = self._policy.features(goals)
        change = weighted_change(features, residuals, weights, self._ridge)
        self._policy.parameters += change
        left = np.square(residuals - features @ change).mean(axis=1)
        spread = np.sqrt(weights @ left / weights.sum())
        self._exploration = max(self._smallest_exploration, float(spread))
