"""A differential inverse model: dq = B(x, q) dx in local maps, learned from motor babbling.

Small random steps from posture to posture give pairs (dx, dq). Where the steps dq have no preferred
direction, the regression of dq on dx,

    B_k = (sum h dq dx') (sum h dx dx')^-1,

is the pseudo-inverse of the Jacobian, J' (J J')^-1, averaged over the map (D'Souza, Vijayakumar and
Schaal, "Learning inverse kinematics", 2001). Solutions of one step are a convex set, so averaging
does no harm there. A goal is reached by integrating along a straight line from home.
"""

import math

import numpy as np

from benchmarks.methods.method import Method
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray


class DifferentialMaps:
    """Local linear maps from outcome steps to action steps.

    A map is made where (x, q) is farther than 1 from all others, in units of the reaches.

    Parameters
    ----------
    outcome_reach, action_reach : float
        Reach of a map [outcome unit], and for each coordinate [action unit].
    ridge : float
        Added to sum h dx dx' [outcome unit squared].
    """

    def __init__(
        self,
        outcome: FloatArray,
        action: FloatArray,
        outcome_reach: float,
        action_reach: float,
        ridge: float,
    ) -> None:
        self._outcome_reach = outcome_reach
        self._action_reach = action_reach * math.sqrt(action.size)
        n, m = outcome.size, action.size
        self._centers = self._place(outcome[np.newaxis], action[np.newaxis])
        self._start = ridge * np.eye(n)
        self._square = self._start[np.newaxis].copy()  # sum h dx dx', shape (K, n, n)
        self._product = np.zeros((1, n, m))  # sum h dx dq', shape (K, n, m)
        self._solved: FloatArray | None = None

    @property
    def count(self) -> int:
        """Number K of maps."""
        return len(self._centers)

    def learn(
        self,
        outcome: FloatArray,
        action: FloatArray,
        outcome_step: FloatArray,
        action_step: FloatArray,
    ) -> None:
        """Take one pair of steps, shapes (n,) and (m,), made at (x, q)."""
        place = self._place(outcome[np.newaxis], action[np.newaxis])
        squared = np.square(self._centers - place).sum(axis=1)
        if squared.min() > 1.0:
            self._centers = np.concatenate([self._centers, place])
            self._square = np.concatenate([self._square, self._start[np.newaxis]])
            self._product = np.concatenate([self._product, np.zeros_like(self._product[:1])])
            squared = np.append(squared, 0.0)
        activation = np.exp(-squared)
        # Most maps are far away; only those that are touched change.
        near = activation > 1e-4
        self._square[near] += activation[near, None, None] * np.outer(outcome_step, outcome_step)
        self._product[near] += activation[near, None, None] * np.outer(outcome_step, action_step)
        self._solved = None

    def inverses(self, outcomes: FloatArray, actions: FloatArray) -> FloatArray:
        """Return B at places (x, q), shapes (N, n) and (N, m), as shape (N, m, n)."""
        if self._solved is None:
            self._solved = np.linalg.solve(self._square, self._product)
        places = self._place(outcomes, actions)
        squared = (
            np.square(places).sum(axis=1)[:, np.newaxis]
            - 2.0 * places @ self._centers.T
            + np.square(self._centers).sum(axis=1)
        )
        h = np.exp(squared.min(axis=1, keepdims=True) - squared)
        h /= h.sum(axis=1, keepdims=True)
        k, n, m = self._solved.shape
        blended: FloatArray = (h @ self._solved.reshape(k, n * m)).reshape(-1, n, m)
        return blended.transpose(0, 2, 1)

    def _place(self, outcomes: FloatArray, actions: FloatArray) -> FloatArray:
        return np.concatenate(
            [outcomes / self._outcome_reach, actions / self._action_reach], axis=1
        )


class DifferentialInverse(Method):
    """Motor babbling as a random walk around home, and a differential inverse of it.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of the walk.
    spread : float
        Standard deviation of the walk's postures around home [action unit].
    walk_step : float
        Standard deviation of a step of the walk [action unit].
    outcome_reach, action_reach : float
        Reach of a map [outcome unit], [action unit].
    ridge : float
        See `DifferentialMaps`.
    integration_steps : int
        Steps from home to a goal.
    """

    def __init__(
        self,
        world: World,
        rng: np.random.Generator,
        *,
        spread: float = 0.5,
        walk_step: float = 0.05,
        outcome_reach: float = 0.2,
        action_reach: float = 0.5,
        ridge: float = 1e-4,
        integration_steps: int = 25,
    ) -> None:
        super().__init__(world)
        self._rng = rng
        self._step = walk_step
        self._keep = spread / math.hypot(spread, walk_step)
        self._steps = integration_steps
        self._maps = DifferentialMaps(
            world.home_outcome, world.home_action, outcome_reach, action_reach, ridge
        )
        self._action, self._outcome = world.home_action, world.home_outcome

    def step(self) -> None:
        """Take one step of the walk and learn it."""
        away = self._action - self.world.home_action
        away = self._keep * (away + self._step * self._rng.standard_normal(away.size))
        action = self.world.clipped(self.world.home_action + away)
        outcome = self.world.execute(action)
        self._maps.learn(
            0.5 * (self._outcome + outcome),
            0.5 * (self._action + action),
            outcome - self._outcome,
            action - self._action,
        )
        self._action, self._outcome = action, outcome

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return the ends of the integration from home; see `Method`.

        Nothing is executed, so the outcome on the way is taken to be where it should be.
        """
        outcomes = np.tile(self.world.home_outcome, (len(goals), 1))
        actions = np.tile(self.world.home_action, (len(goals), 1))
        step = (goals - outcomes) / self._steps
        for _ in range(self._steps):
            inverses = self._maps.inverses(outcomes, actions)
            change = np.einsum("amn,an->am", inverses, step)
            actions = self.world.clipped(actions + change)
            outcomes = outcomes + step
        return actions
