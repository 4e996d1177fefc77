"""What a learner comes to know of its body beside the inverse model, and what that is good for.

Goal babbling learns which action brings an outcome. The same examples also tell which outcome an
action brings (`ForwardModel`), what the sensors of the actions are off by just now
(`SensorOffsets`), and where actions come to an end (`ReachableRange`). With these an answer of the
inverse model is refined (`refinement`): the inverse model chooses the solution, the forward model
takes away what the average over many examples leaves. As the refined action is executed and
learned from, the inverse model comes to say it by itself.
"""

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.forward_model import ForwardModel
from bha_goal_babbling.reachable_range import ReachableRange
from bha_goal_babbling.refinement import refined
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.sensor_offsets import SensorOffsets

_MARGIN = 0.027
"""How far a reading lies beyond what was commanded when it is stuck, in scaled units. Twice that of
`FoundEnds`: exploration does not wait until lengths rest, and a finer one taught it no more."""
_REACH = 0.6
"""How far an answer of the inverse model is moved at most beyond its range, in scaled units."""
_BEYOND = 0.06
"""How far beyond the ends that were learned a robot in use tries at most, in scaled units."""


class BodyModel:
    """Refines actions and corrects readings, in the units of the robot.

    Parameters
    ----------
    config : GoalBabblerConfig
        Scales, noise and offsets.
    home_action, home_outcome : array
        Home, shapes (m,) and (n,).
    low, high : array
        Limits that no action exceeds, shape (m,).
    """

    def __init__(
        self,
        config: GoalBabblerConfig,
        home_action: FloatArray,
        home_outcome: FloatArray,
        low: FloatArray,
        high: FloatArray,
    ) -> None:
        self._action_scale, self._outcome_scale = config.action_scale, config.outcome_scale
        home = (home_action / self._action_scale, home_outcome / self._outcome_scale)
        self._forward = ForwardModel(*home, config.outcome_noise / self._outcome_scale)
        self._offsets = SensorOffsets(
            home_action.size, config.offset_spread / self._action_scale, config.offset_samples
        )
        ends = (low / self._action_scale, high / self._action_scale)
        self._range = ReachableRange(home[1], *ends, _MARGIN)

    @property
    def offsets(self) -> FloatArray:
        """What readings of the action are off by [action unit], shape (m,)."""
        return self._offsets.values * self._action_scale

    def refine(
        self,
        action: FloatArray,
        goal: FloatArray,
        low: FloatArray | float = -np.inf,
        high: FloatArray | float = np.inf,
        *,
        explores: bool = False,
    ) -> FloatArray:
        """Return an action near a given one, shape (m,), that brings a goal, shape (n,).

        Exploration learns the ends on the way. A robot in use stays, and what creeps goes further
        than it did on the way. Where the ends leave a goal out it tries beyond them, by as much as
        is missed there; who watches it (`FoundEnds`) sees what stays short.

        Parameters
        ----------
        action, goal : array
            Where to begin, and the goal.
        low, high : array, optional
            Ends that were found just now, shape (m,): what was learned of ends gives way to them.
        explores : bool
            Whether it is to find out: then ends hold, and what the model does not know does not
            count (`refined`).
        """
        goal = goal / self._outcome_scale
        scaled = action / self._action_scale
        found = low / self._action_scale, high / self._action_scale
        low, high = self._range.at(goal)

        def answer(beyond: float) -> FloatArray:
            ends = np.clip(low - beyond, *found), np.clip(high + beyond, *found)
            return refined(scaled, goal, self._forward, *ends, _REACH, cautious=not explores)

        within = answer(0.0)
        if explores:
            return within * self._action_scale
        missed = float(np.linalg.norm(goal - self._forward.predict(within)))
        return answer(min(missed, _BEYOND)) * self._action_scale

    def predict(self, action: FloatArray) -> FloatArray:
        """Return the outcome, shape (n,), of an action without offsets, shape (m,)."""
        return self._forward.predict(action / self._action_scale) * self._outcome_scale

    def learn(
        self, reading: FloatArray, outcome: FloatArray, command: FloatArray | None = None
    ) -> FloatArray:
        """Learn an example.

        Parameters
        ----------
        reading : array
            The action as it was measured, shape (m,).
        outcome : array
            What came of it, shape (n,).
        command : array, optional
            The reading that was asked for, shape (m,); None where the robot went its own way, and
            may have been anywhere since the example before.

        Returns
        -------
        array
            The action without offsets, shape (m,).
        """
        scaled, seen = reading / self._action_scale, outcome / self._outcome_scale
        if command is None:
            self.pause()
        self._forward.learn(*self._follow(scaled, seen))
        action = scaled - self._offsets.values
        if command is not None:
            self._range.learn(command / self._action_scale - self._offsets.values, action, seen)
        return action * self._action_scale

    def follow_offsets(self, reading: FloatArray, outcome: FloatArray) -> None:
        """Take from an example, shapes (m,) and (n,), only what readings are off by.

        The robot may have been anywhere since the example before.
        """
        self.pause()
        self._follow(reading / self._action_scale, outcome / self._outcome_scale)
        self.pause()

    def pause(self) -> None:
        """Forget what the robot was about: the next example is taken as one at rest."""
        self._forward.pause()
        self._range.pause()

    def _follow(self, scaled: FloatArray, seen: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Learn offsets; return features and miss of the example for the forward model."""
        action = scaled - self._offsets.values
        features, expected, unknown = self._forward.expect(action)
        missed = seen - expected
        variance = self._forward.variance + unknown
        self._offsets.learn(self._forward.jacobian(action), missed, variance)
        return features, missed

    def state(self) -> SavedState:
        """Return everything that `load` needs besides the config."""
        return SavedState().joined(
            forward=self._forward.state(),
            offsets=self._offsets.state(),
            range=self._range.state(),
        )

    def load(self, state: SavedState) -> None:
        """Take over a snapshot of a model of the same sizes; it continues bit for bit.

        Raises
        ------
        InvalidConfigError, InvalidArrayError
            If something in the snapshot does not fit.
        """
        own = self.state().arrays
        for name in ("forward_home", "forward_parameters", "offsets_values", "range_low"):
            if state.arrays[name].shape != own[name].shape:
                raise InvalidConfigError(
                    f"{name} has shape {state.arrays[name].shape}, expected {own[name].shape}"
                )
        forward = ForwardModel.restore(state.part("forward"))
        offsets = SensorOffsets.restore(state.part("offsets"))
        ends = ReachableRange.restore(state.part("range"))
        self._forward, self._offsets, self._range = forward, offsets, ends
