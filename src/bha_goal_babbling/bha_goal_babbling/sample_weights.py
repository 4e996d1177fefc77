"""How much an example counts: w = w_dir w_eff, equations 4 and 5 of the article.

    w_dir = (1 + cos angle(x*_t - x*_{t-1}, x_t - x_{t-1})) / 2
    w_eff = |x_t - x_{t-1}| / |q_t - q_{t-1}|

w_dir drops examples that moved against the intention, w_eff those that moved the actions for
nothing; together they resolve inconsistent solutions. w_eff has a unit (outcome per action), so it
scales the learning rate; `SampleWeights` can limit it, or make it free of units by dividing it by
its running mean.
"""

import math

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState

MEAN_START = 0.3
MEAN_RATE = 0.01
MEAN_HEAD_START = 5


def direction_weight(
    target_step: FloatArray, outcome_step: FloatArray, resolution: float = 0.0
) -> float:
    """Return w_dir in [0, 1].

    Parameters
    ----------
    target_step : array
        x*_t - x*_{t-1}, shape (n,).
    outcome_step : array
        x_t - x_{t-1}, shape (n,).
    resolution : float
        Length of an outcome step, in the unit of outcomes, at or below which its direction is
        noise. Such a step, and a target that stands still, say nothing about direction: 1/2.
    """
    target_length = math.sqrt(float(target_step.dot(target_step)))
    outcome_length = math.sqrt(float(outcome_step.dot(outcome_step)))
    if target_length == 0.0 or outcome_length <= resolution:
        return 0.5
    # Lengths divide one after the other: their product could underflow. The cosine of two
    # parallel steps may be 1 + 1e-16.
    cosine = float((target_step / target_length).dot(outcome_step / outcome_length))
    return 0.5 * (1.0 + min(1.0, max(-1.0, cosine)))


def movement_efficiency(
    action_step: FloatArray, outcome_step: FloatArray, resolution: float = 0.0
) -> float:
    """Return w_eff, outcome per action, at least 0.

    Parameters
    ----------
    action_step : array
        q_t - q_{t-1}, shape (m,).
    outcome_step : array
        x_t - x_{t-1}, shape (n,).
    resolution : float
        Length of an action step, in the unit of actions, at or below which it cannot be told from
        the noise of the sensors. Where nothing was moved nothing can be learned: 0.
    """
    action_length = math.sqrt(float(action_step.dot(action_step)))
    if action_length <= resolution:
        return 0.0
    return math.sqrt(float(outcome_step.dot(outcome_step))) / action_length


class SampleWeights:
    """Weights of successive examples.

    Parameters
    ----------
    limit : float, optional
        Largest efficiency that counts; larger ones count as this. No limit by default.
    relative : bool
        Divide the efficiency by its running mean first, so that no unit is left in it.
    action_resolution, outcome_resolution : float
        See `movement_efficiency` and `direction_weight`.
    use_direction, use_efficiency : bool
        False leaves w_dir at 1, or w_eff at 1 for every step that moved the action.
    """

    def __init__(
        self,
        limit: float | None = None,
        relative: bool = False,
        action_resolution: float = 0.0,
        outcome_resolution: float = 0.0,
        use_direction: bool = True,
        use_efficiency: bool = True,
    ) -> None:
        if limit is not None and not limit > 0:
            raise InvalidConfigError(f"limit must be above 0 or None, got {limit}")
        self._limit = limit
        self._relative = relative
        self._action_resolution = action_resolution
        self._outcome_resolution = outcome_resolution
        self._use_direction = use_direction
        self._use_efficiency = use_efficiency
        self._mean = MEAN_START
        self._count = 0

    def of_goal_step(
        self, target_step: FloatArray, action_step: FloatArray, outcome_step: FloatArray
    ) -> float:
        """Return w = w_dir w_eff of a step towards a goal."""
        efficiency = self.of_home_step(action_step, outcome_step)
        if not self._use_direction:
            return efficiency
        return efficiency * direction_weight(target_step, outcome_step, self._outcome_resolution)

    def of_home_step(self, action_step: FloatArray, outcome_step: FloatArray) -> float:
        """Return w = w_eff of a step towards home, which intends no direction of the outcome."""
        efficiency = movement_efficiency(action_step, outcome_step, self._action_resolution)
        if not self._use_efficiency:
            # A stuck robot teaches nothing, whatever is weighted.
            moved = action_step.dot(action_step) > self._action_resolution**2
            return 1.0 if moved else 0.0
        if self._relative:
            efficiency = self._divided_by_mean(efficiency)
        return efficiency if self._limit is None else min(efficiency, self._limit)

    def _divided_by_mean(self, efficiency: float) -> float:
        if efficiency == 0.0:
            return 0.0
        # Quick at first, then slow: a mean of the last hundred or so.
        rate = max(MEAN_RATE, 1.0 / (self._count + MEAN_HEAD_START))
        self._count += 1
        self._mean += rate * (efficiency - self._mean)
        return efficiency / self._mean

    def state(self) -> SavedState:
        """Return what `load` needs."""
        return SavedState(settings={"mean": self._mean, "count": self._count})

    def load(self, state: SavedState) -> None:
        """Take over the running mean of a snapshot."""
        self._mean = float(state.settings["mean"])
        self._count = int(state.settings["count"])
