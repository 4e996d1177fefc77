"""An inverse model in the units of the robot, trained with weighted examples.

The model itself sees actions divided by `action_scale` and outcomes divided by `outcome_scale`, so
that its learning rate means the same in whatever units the robot is described.
"""

from collections.abc import Callable

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_recursive_maps import CompiledRecursiveMaps
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.inverse_model import InverseModel
from bha_goal_babbling.local_linear_map import LocalLinearMaps
from bha_goal_babbling.recursive_maps import RecursiveMapsConfig
from bha_goal_babbling.sample_weights import SampleWeights
from bha_goal_babbling.saved_state import SavedState

_RESTORE: dict[str, Callable[[SavedState], InverseModel]] = {
    LocalLinearMaps.kind: LocalLinearMaps.restore,
    CompiledRecursiveMaps.kind: CompiledRecursiveMaps.restore,
}


class ScaledModel:
    """Answers in actions, learns from actions and outcomes, each weighted by what it is worth.

    Parameters
    ----------
    config : GoalBabblerConfig
        Scales, and what the weights depend on.
    model : InverseModel
        The model, in scaled units.
    """

    def __init__(self, config: GoalBabblerConfig, model: InverseModel) -> None:
        self.model = model
        self._action_scale = config.action_scale
        self._outcome_scale = config.outcome_scale
        self._weights = SampleWeights(
            config.efficiency_limit,
            config.efficiency == "relative",
            config.action_resolution / config.action_scale,
            config.outcome_resolution / config.outcome_scale,
            config.direction == "plain",
            config.efficiency != "none",
        )

    @classmethod
    def at_home(
        cls, config: GoalBabblerConfig, home_action: FloatArray, home_outcome: FloatArray
    ) -> "ScaledModel":
        """Return a model of the kind `config.model` that answers every goal with the home action.

        Parameters
        ----------
        config : GoalBabblerConfig
            All settings.
        home_action, home_outcome : array
            Home, shapes (m,) and (n,).
        """
        distance = config.map_distance / config.outcome_scale
        home = (home_outcome / config.outcome_scale, home_action / config.action_scale)
        if config.model == LocalLinearMaps.kind:
            return cls(config, LocalLinearMaps(distance, config.learning_rate, *home))
        final = config.final_map_distance
        recursive = RecursiveMapsConfig(
            distance,
            distance if final is None else final / config.outcome_scale,
            config.shrink_samples,
            config.covariance,
            config.covariance_limit,
            config.process_noise,
            config.blend_samples,
        )
        return cls(config, CompiledRecursiveMaps(recursive, *home))

    def predict(self, outcome: FloatArray) -> FloatArray:
        """Return g at one outcome, shape (n,), as an action, shape (m,)."""
        return self.model.predict(outcome / self._outcome_scale) * self._action_scale

    def predict_many(self, outcomes: FloatArray) -> FloatArray:
        """Return g at many outcomes, shape (N, n), as actions, shape (N, m)."""
        return self.model.predict_many(outcomes / self._outcome_scale) * self._action_scale

    def learn(
        self,
        action: FloatArray,
        outcome: FloatArray,
        action_step: FloatArray,
        outcome_step: FloatArray,
        target_step: FloatArray | None,
    ) -> None:
        """Learn from one example, as much as it is worth; without worth nothing changes.

        Parameters
        ----------
        action, outcome : array
            q_t, shape (m,), and x_t, shape (n,).
        action_step, outcome_step : array
            q_t - q_{t-1}, shape (m,), and x_t - x_{t-1}, shape (n,).
        target_step : array or None
            x*_t - x*_{t-1}, shape (n,); None on the way home, which intends none.
        """
        steps = (action_step / self._action_scale, outcome_step / self._outcome_scale)
        if target_step is None:
            weight = self._weights.of_home_step(*steps)
        else:
            weight = self._weights.of_goal_step(target_step / self._outcome_scale, *steps)
        if weight > 0.0:
            self.model.learn(outcome / self._outcome_scale, action / self._action_scale, weight)

    def state(self) -> SavedState:
        """Return everything that `restore` needs besides the config."""
        return SavedState(settings={"kind": self.model.kind}).joined(
            maps=self.model.state(), weights=self._weights.state()
        )

    @classmethod
    def restore(cls, config: GoalBabblerConfig, state: SavedState) -> "ScaledModel":
        """Return the model whose snapshot this is; it continues bit for bit.

        Raises
        ------
        InvalidConfigError
            If the snapshot is of an unknown kind of model.
        """
        kind = state.settings["kind"]
        if kind not in _RESTORE:
            raise InvalidConfigError(f"unknown model {kind!r}; known are {', '.join(_RESTORE)}")
        restored = cls(config, _RESTORE[kind](state.part("maps")))
        restored._weights.load(state.part("weights"))
        return restored
