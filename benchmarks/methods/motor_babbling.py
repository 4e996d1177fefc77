"""Motor babbling: random actions, a forward model of them, and its inverse Jacobian to reach.

The exploration of section 1 of the article ("forward models for control"): actions are drawn at
random around home, a forward model is fitted, and goals are searched on it.
"""

import numpy as np

from benchmarks.methods.forward_model import USUAL, ForwardModel, ForwardModelSettings
from benchmarks.methods.method import Method
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray


def random_action(world: World, spread: float, rng: np.random.Generator) -> FloatArray:
    """Return an action drawn uniformly within the limits around home, shape (m,).

    Parameters
    ----------
    world : World
        Home and limits.
    spread : float
        Largest distance from home of every coordinate [action unit].
    rng : numpy.random.Generator
        Source of the action.
    """
    low = np.maximum(world.action_low, world.home_action - spread)
    high = np.minimum(world.action_high, world.home_action + spread)
    return rng.uniform(low, high)


class MotorBabbling(Method):
    """Random actions, forward model, inverse Jacobian.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of all randomness.
    spread : float
        Largest distance from home of every coordinate of an action [action unit].
    forward_model : ForwardModelSettings
        Settings of the forward model.
    home_pull : float
        Pull towards home in the null space when goals are searched; 0 for none.
    """

    def __init__(
        self,
        world: World,
        rng: np.random.Generator,
        *,
        spread: float = 0.5,
        forward_model: ForwardModelSettings = USUAL,
        home_pull: float = 0.0,
    ) -> None:
        super().__init__(world)
        self._rng = rng
        self._spread = spread
        self._home_pull = home_pull
        self._model = ForwardModel(world.home_action, world.home_outcome, forward_model, rng)

    def step(self) -> None:
        """Execute a random action and learn the forward model."""
        action = random_action(self.world, self._spread, self._rng)
        self._model.learn(action, self.world.execute(action))

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return actions that reach goals on the forward model; see `Method`."""
        return self._model.reach(goals, self.world, self._home_pull)
