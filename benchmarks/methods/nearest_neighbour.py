"""Goal babbling with a nearest neighbour: repeat, slightly changed, what came closest to the goal.

Goals are drawn uniformly in a box; the command is the one among those executed whose outcome was
nearest, with fresh noise (Moulin-Frier and Oudeyer, "Exploration strategies in developmental
robotics: a unified probabilistic framework", 2013; Benureau, "Self-exploration of sensorimotor
spaces in robots", 2015).
"""

import numpy as np
from scipy.spatial import cKDTree

from benchmarks.methods.method import Method
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray

_LARGEST_BUFFER = 100
"""Samples that are searched one by one before they go into the tree."""


class NearestNeighbour(Method):
    """Remembers everything, models nothing.

    Parameters
    ----------
    world : World
        Where it acts; goals are drawn in the bounding box of its goals.
    rng : numpy.random.Generator
        Source of goals and noise.
    exploration : float
        Standard deviation of the noise [action unit].
    """

    def __init__(self, world: World, rng: np.random.Generator, *, exploration: float = 0.1) -> None:
        super().__init__(world)
        self._rng = rng
        self._exploration = exploration
        self._low, self._high = world.goals.min(axis=0), world.goals.max(axis=0)
        self._actions = [world.home_action]
        self._outcomes = [world.home_outcome]
        self._tree = cKDTree(np.array(self._outcomes))

    def step(self) -> None:
        """Try a goal with the nearest neighbour's action and some noise."""
        goal = self._rng.uniform(self._low, self._high)
        noise = self._exploration * self._rng.standard_normal(self.world.home_action.size)
        action = self.world.clipped(self.inverse(goal[np.newaxis])[0] + noise)
        self._outcomes.append(self.world.execute(action))
        self._actions.append(action)
        if len(self._outcomes) - self._tree.n > _LARGEST_BUFFER:
            self._tree = cKDTree(np.array(self._outcomes))

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return the executed actions whose outcomes were nearest; see `Method`."""
        distances, indices = self._tree.query(goals)
        recent = np.array(self._outcomes[self._tree.n :])
        if len(recent):
            gaps = np.linalg.norm(goals[:, np.newaxis] - recent, axis=2)
            nearest = gaps.argmin(axis=1)
            closer = gaps[np.arange(len(goals)), nearest] < distances
            indices = np.where(closer, self._tree.n + nearest, indices)
        return np.array([self._actions[index] for index in indices])
