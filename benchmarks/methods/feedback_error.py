"""Feedback-error learning: a feedback controller that is given beforehand teaches the inverse.

    q_1 = g(x*),   q_{s+1} = q_s + u_s,   u_s = K(q_s) (x* - x_s),   g(x*) += rate u_s

What feedback adds to the feed-forward command is the error of that command, in the space of
actions (Kawato, "Feedback-error-learning neural network for supervised motor learning", 1990). K
needs the Jacobian of the robot: prior knowledge that no other of the compared methods has.
"""

from collections.abc import Callable

import numpy as np

from benchmarks.methods.goal_features import GoalModel
from benchmarks.methods.inverse_jacobian import damped_inverse
from benchmarks.methods.method import Method
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.goal_choice import RandomGoalChoice

Feedback = Callable[[FloatArray, FloatArray], FloatArray]
"""Action step for an action, shape (m,), and an error of the outcome, shape (n,): shape (m,)."""


def inverse_jacobian(
    jacobian: Callable[[FloatArray], FloatArray], gain: float = 1.0, damping: float = 0.1
) -> Feedback:
    """Return the feedback u = gain J^+ e.

    Parameters
    ----------
    jacobian : callable
        The robot's Jacobian, shape (m,) to shape (n, m).
    gain : float
        Share of the error that one step is to remove.
    damping : float
        See `damped_inverse`.
    """

    def feedback(action: FloatArray, error: FloatArray) -> FloatArray:
        step: FloatArray = gain * damped_inverse(jacobian(action)[np.newaxis], damping)[0] @ error
        return step

    return feedback


class FeedbackErrorLearning(Method):
    """Reaches for goals, feed-forward first, then with feedback; what feedback adds is learned.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of the goals.
    feedback : Feedback
        The controller that is given.
    steps : int
        Actions of one reach, the feed-forward one included.
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
        steps: int = 3,
        rate: float = 1.0,
        distance: float = 0.2,
    ) -> None:
        super().__init__(world)
        self._rng = rng
        self._feedback = feedback
        self._steps = steps
        self._rate = rate
        self._model = GoalModel(world.goals, distance, world.home_action)
        self._choice = RandomGoalChoice(len(world.goals))
        self._goal = world.home_outcome
        self._action = world.home_action

    def step(self) -> None:
        """Take one step of a reach; learn what feedback says about it."""
        if self.samples % self._steps == 0:
            self._goal = self.world.goals[self._choice.choose(self._rng)]
            self._action = self.world.clipped(self._model(self._goal[np.newaxis])[0])
        outcome = self.world.execute(self._action)
        correction = self._feedback(self._action, self._goal - outcome)
        self._model.change(self._goal, correction, self._rate)
        self._action = self.world.clipped(self._action + correction)

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return the feed-forward commands; see `Method`."""
        return self.world.clipped(self._model(goals))
