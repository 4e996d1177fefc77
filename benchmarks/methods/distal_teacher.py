"""Distal teacher: the error of the outcome, led back through a learned forward model.

    E = |x* - f(g(x*))|^2 / 2,   -dE/dq ~ J' (x* - x),   J the Jacobian of the learned f at q

(Jordan and Rumelhart, "Forward models: supervised learning with a distal teacher", 1992: the
"performance error", the observed outcome with the Jacobian of the model). The forward model is
learned from the same examples; some of the first ones are motor babbling, without which it would
have no Jacobian.
"""

import numpy as np

from benchmarks.methods.forward_model import USUAL, ForwardModel, ForwardModelSettings
from benchmarks.methods.goal_features import GoalModel
from benchmarks.methods.method import Method
from benchmarks.methods.motor_babbling import random_action
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.goal_paths import GoalPaths


def distal_step(jacobian: FloatArray, error: FloatArray) -> FloatArray:
    """Return -dE/dq = J' (x* - x), shape (m,), of a Jacobian (n, m) and an error (n,)."""
    step: FloatArray = jacobian.T @ error
    return step


class DistalTeacher(Method):
    """Babbles, then practises goals; forward model and inverse model learn together.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of all randomness.
    babbling : int
        Number of random actions at the beginning.
    spread : float
        Largest distance from home of every coordinate of a random action [action unit].
    exploration : float
        Standard deviation of the noise when goals are practised [action unit].
    path_steps : int
        Steps of a path from goal to goal.
    rate : float
        Step of the gradient, divided by the squared norm of the Jacobian.
    distance : float
        Spacing of the inverse model's features [outcome unit].
    forward_model : ForwardModelSettings
        Settings of the forward model.
    """

    def __init__(
        self,
        world: World,
        rng: np.random.Generator,
        *,
        babbling: int = 100,
        spread: float = 0.5,
        exploration: float = 0.03,
        path_steps: int = 5,
        rate: float = 1.0,
        distance: float = 0.2,
        forward_model: ForwardModelSettings = USUAL,
    ) -> None:
        super().__init__(world)
        self._rng = rng
        self._babbling = babbling
        self._spread = spread
        self._exploration = exploration
        self._rate = rate
        self._forward = ForwardModel(world.home_action, world.home_outcome, forward_model, rng)
        self._model = GoalModel(world.goals, distance, world.home_action)
        self._paths = GoalPaths(world.goals, path_steps)
        self._paths.begin(world.home_outcome, world.home_outcome, rng)

    def step(self) -> None:
        """Babble, or practise one step of a path."""
        if self.samples < self._babbling:
            action = random_action(self.world, self._spread, self._rng)
            self._forward.learn(action, self.world.execute(action))
            return
        target = self._paths.target()
        noise = self._exploration * self._rng.standard_normal(self.world.home_action.size)
        action = self.world.clipped(self._model(target[np.newaxis])[0] + noise)
        outcome = self.world.execute(action)
        self._forward.learn(action, outcome)
        jacobian = self._forward.jacobian(action[np.newaxis])[0]
        scale = np.linalg.norm(jacobian, 2) ** 2
        if scale > 0.0:
            # The noise was not the model's doing: what is corrected is the miss without it.
            error = target - outcome + jacobian @ noise
            self._model.change(target, distal_step(jacobian, error) / scale, self._rate)
        if self._paths.advance(np.zeros_like(outcome)):
            self._paths.begin(target, outcome, self._rng)

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return the inverse model's answers; see `Method`."""
        return self.world.clipped(self._model(goals))
