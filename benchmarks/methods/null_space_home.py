"""Goal-directed exploration with a forward model, home kept in the null space.

    q_t = q_{t-1} + J^+ (x*_t - x_{t-1}) + (I - J^+ J) a (q_home - q_{t-1}) + noise

J is that of a forward model learned on the way (Jamone, Natale, Hashimoto, Sandini and Takanishi,
"Learning task space control through goal directed exploration", 2011). Along a path it is feedback
control with the model learned so far; the pull towards home keeps redundant joints from drifting.
"""

import numpy as np

from benchmarks.methods.forward_model import USUAL, ForwardModel, ForwardModelSettings
from benchmarks.methods.inverse_jacobian import resolved_step
from benchmarks.methods.method import Method
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.goal_paths import GoalPaths


class NullSpaceHome(Method):
    """Paths between goals, controlled by the learned Jacobian.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of all randomness.
    path_steps : int
        Steps of a path from goal to goal.
    exploration : float
        Standard deviation of the noise [action unit].
    largest_step : float
        Longest step of the action, before the noise [action unit]: the model may be wrong.
    home_pull : float
        Share a of the way home, in the null space.
    forward_model : ForwardModelSettings
        Settings of the forward model.
    """

    def __init__(
        self,
        world: World,
        rng: np.random.Generator,
        *,
        path_steps: int = 5,
        exploration: float = 0.03,
        largest_step: float = 0.3,
        home_pull: float = 0.1,
        forward_model: ForwardModelSettings = USUAL,
    ) -> None:
        super().__init__(world)
        self._rng = rng
        self._exploration = exploration
        self._largest_step = largest_step
        self._home_pull = home_pull
        self._model = ForwardModel(world.home_action, world.home_outcome, forward_model, rng)
        self._paths = GoalPaths(world.goals, path_steps)
        self._action, self._outcome = world.home_action, world.home_outcome
        self._paths.begin(world.home_outcome, world.home_outcome, rng)

    def step(self) -> None:
        """Go one step along the path and learn the forward model."""
        target = self._paths.target()
        step = resolved_step(
            self._model.jacobian(self._action[np.newaxis]),
            (target - self._outcome)[np.newaxis],
            self._home_pull * (self.world.home_action - self._action)[np.newaxis],
            0.05,
        )[0]
        step *= min(1.0, self._largest_step / max(float(np.linalg.norm(step)), 1e-12))
        step += self._exploration * self._rng.standard_normal(step.size)
        action = self.world.clipped(self._action + step)
        outcome = self.world.execute(action)
        self._model.learn(action, outcome)
        over = self._paths.advance(outcome - self._outcome)
        self._action, self._outcome = action, outcome
        if over:
            self._paths.begin(target, outcome, self._rng)

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return actions that reach goals on the forward model; see `Method`."""
        return self._model.reach(goals, self.world, self._home_pull)
