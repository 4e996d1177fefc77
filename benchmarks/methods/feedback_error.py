"""Feedback-error learning: a feedback controller that is given beforehand teaches the inverse.

    q_t = g(x*_t) + u_t,   u_t = K(q_{t-1}) (x*_{t-1} - x_{t-1}),   g(x*_t) += rate u_t

The command of the feedback controller is the error of the feed-forward one, in the space of actions
(Kawato, "Feedback-error-learning neural network for supervised motor learning", 1990). K needs the
Jacobian of the robot: prior knowledge that no other of the compared methods has.
"""

from collections.abc import Callable

import numpy as np

from benchmarks.methods.goal_features import GoalModel
from benchmarks.methods.inverse_jacobian import damped_inverse
from benchmarks.methods.method import Method
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.goal_paths import GoalPaths

Feedback = Callable[[FloatArray, FloatArray], FloatArray]
"""Action step for an action, shape (m,), and an error of the outcome, shape (n,): shape (m,)."""


def inverse_jacobian(
    jacobian: Callable[[FloatArray], FloatArray], gain: float = 0.5, damping: float = 0.1
) -> Feedback:
    """Return the feedback u = gain J^+ e.

    Parameters
    ----------
    jacobian : callable
        The robot's Jacobian, shape (m,) to shape (n, m).
    gain : float
        Below 1: u_t answers to what came of u_{t-1}, and with all of it the two take turns.
    damping : float
        See `damped_inverse`.
    """

    def feedback(action: FloatArray, error: FloatArray) -> FloatArray:
        step: FloatArray = gain * damped_inverse(jacobian(action)[np.newaxis], damping)[0] @ error
        return step

    return feedback


class FeedbackErrorLearning(Method):
    """Paths between goals; what feedback adds is learned.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of the goals.
    feedback : Feedback
        The controller that is given.
    path_steps : int
        Steps of a path from goal to goal.
    rate : float
        Share of the feedback that is learned.
    distance : float
        Spacing of the inverse model's features [outcome unit].
    """

    def __init__(
        self,
        world: World,
        rng: np.random.Generator,
        feedback: Feedback,
        *,
        path_steps: int = 25,
        rate: float = 1.0,
        distance: float = 0.2,
    ) -> None:
        super().__init__(world)
        self._rng = rng
        self._feedback = feedback
        self._rate = rate
        self._model = GoalModel(world.goals, distance, world.home_action)
        self._paths = GoalPaths(world.goals, path_steps)
        self._paths.begin(world.home_outcome, world.home_outcome, rng)
        self._correction = np.zeros_like(world.home_action)

    def step(self) -> None:
        """Go one step along the path; learn what feedback says about it."""
        target = self._paths.target()
        action = self.world.clipped(self._model(target[np.newaxis])[0] + self._correction)
        outcome = self.world.execute(action)
        self._model.change(target, self._correction, self._rate)
        self._correction = self._feedback(action, target - outcome)
        if self._paths.advance(np.zeros_like(outcome)):
            self._paths.begin(target, outcome, self._rng)

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return the feed-forward commands; see `Method`."""
        return self.world.clipped(self._model(goals))
