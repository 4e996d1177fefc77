"""What a learner knows from its examples: an inverse model, refined by a body model if it has one.

The inverse model g says which action brings an outcome. Where there is a body model, that answer
is refined, and told as what the sensors are to read.
"""

import numpy as np
from numpy.typing import ArrayLike

from bha_goal_babbling.arrays import FloatArray, matrix, vector
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.body_model import BodyModel
from bha_goal_babbling.inverse_model import InverseModel
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.scaled_model import ScaledModel


class Knowledge:
    """Answers goals, and learns from one example after the other, in the units of the robot.

    Parameters
    ----------
    config : GoalBabblerConfig
        All settings.
    home_action, home_outcome : array
        The first example, shapes (m,) and (n,).
    low, high : array
        Limits that no answer exceeds, shape (m,).
    model : InverseModel, optional
        The inverse model to train, in scaled units; of the kind `config.model` by default.
    """

    def __init__(
        self,
        config: GoalBabblerConfig,
        home_action: FloatArray,
        home_outcome: FloatArray,
        low: FloatArray,
        high: FloatArray,
        model: InverseModel | None = None,
    ) -> None:
        self._config = config
        self._low, self._high = low, high
        self._learned = (
            ScaledModel.at_home(config, home_action, home_outcome)
            if model is None
            else ScaledModel(config, model)
        )
        self._body = (
            None
            if config.forward_model == "none"
            else BodyModel(config, home_action, home_outcome, low, high)
        )
        self.action = home_action  # of the last example
        self.outcome = home_outcome

    @property
    def model(self) -> InverseModel:
        """The inverse model, in scaled units."""
        return self._learned.model

    def solution(
        self,
        goal: FloatArray,
        low: FloatArray | float = -np.inf,
        high: FloatArray | float = np.inf,
        *,
        explores: bool = False,
    ) -> FloatArray:
        """Return the action, shape (m,), that is to bring a goal, shape (n,).

        Parameters
        ----------
        goal : array
            The goal.
        low, high : array, optional
            Lowest and highest readings that can be had now, shape (m,), if more is known of them
            than was learned.
        explores : bool
            Whether it is to find out: then the answer may lie where the body model knows little.
        """
        action = self._learned.predict(goal)
        if self._body is None:
            return action
        offsets = self._body.offsets
        return self._body.refine(action, goal, low - offsets, high - offsets, explores=explores)

    def reading(self, action: FloatArray) -> FloatArray:
        """Return what sensors are to read of actions, shape (..., m), within the limits."""
        reading = action if self._body is None else action + self._body.offsets
        return np.minimum(np.maximum(reading, self._low), self._high)

    def inverse(
        self,
        goal: ArrayLike,
        low: FloatArray | float = -np.inf,
        high: FloatArray | float = np.inf,
    ) -> FloatArray:
        """Return what sensors are to read for one goal, shape (n,), or for many, shape (N, n).

        The ends are those of `solution`; they go with one goal.
        """
        n = self.outcome.size
        if np.ndim(goal) == 1:
            return self.reading(self.solution(vector("goal", goal, n), low, high))
        goals = matrix("goal", goal, n)
        if self._body is None:
            return self.reading(self._learned.predict_many(goals))
        return np.array([self.reading(self.solution(each)) for each in goals])

    def learn(
        self,
        reading: FloatArray,
        outcome: FloatArray,
        command: FloatArray | None,
        target_step: FloatArray | None,
    ) -> None:
        """Learn an example.

        Parameters
        ----------
        reading, outcome : array
            What was measured, shape (m,), and what came of it, shape (n,).
        command : array or None
            The reading that was asked for, shape (m,); None where the robot went its own way.
        target_step : array or None
            x*_t - x*_{t-1}, shape (n,); None where no outcome was intended.
        """
        action = reading if self._body is None else self._body.learn(reading, outcome, command)
        self._learned.learn(
            action, outcome, action - self.action, outcome - self.outcome, target_step
        )
        self.action, self.outcome = action, outcome

    def follow_offsets(self, reading: FloatArray, outcome: FloatArray) -> None:
        """Take from an example, shapes (m,) and (n,), only what readings are off by."""
        if self._body is not None:
            self._body.follow_offsets(reading, outcome)

    def pass_over(self, reading: FloatArray, outcome: FloatArray) -> None:
        """Take an example as the last one, shapes (m,) and (n,), without learning from it."""
        self.pause()
        self.action = reading if self._body is None else reading - self._body.offsets
        self.outcome = outcome

    def pause(self) -> None:
        """Take note that the robot has come to rest, or was elsewhere, since the last example."""
        if self._body is not None:
            self._body.pause()

    def state(self) -> SavedState:
        """Return everything that `load` needs besides the config."""
        parts = {"learned": self._learned.state()}
        if self._body is not None:
            parts["body"] = self._body.state()
        last = {"last_action": self.action, "last_outcome": self.outcome}
        return SavedState(last).joined(**parts)

    def load(self, state: SavedState) -> None:
        """Take over a snapshot; it continues bit for bit."""
        self._learned = ScaledModel.restore(self._config, state.part("learned"))
        if self._body is not None:
            self._body.load(state.part("body"))
        self.action = vector("last_action", state.arrays["last_action"], self.action.size)
        self.outcome = vector("last_outcome", state.arrays["last_outcome"], self.outcome.size)
