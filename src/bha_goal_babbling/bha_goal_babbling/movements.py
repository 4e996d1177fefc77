"""The order of movements: to goals, and now and then home; what each step intends."""

from collections.abc import Callable

import numpy as np

from bha_goal_babbling.arrays import FloatArray, matrix_or_empty, vector
from bha_goal_babbling.direction_sampling import DirectionTargets
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_paths import GoalPaths
from bha_goal_babbling.monitored_paths import MonitoredGoalPaths
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.straight_walk import straight_line
from bha_goal_babbling.target_source import TargetSource

_RESTORE: dict[str, Callable[[SavedState], TargetSource]] = {
    GoalPaths.kind: GoalPaths.restore,
    MonitoredGoalPaths.kind: MonitoredGoalPaths.restore,
    DirectionTargets.kind: DirectionTargets.restore,
}


class Movements:
    """Movements from a source of targets, with some towards home among them.

    A movement home is a straight line in the space of actions. It never comes twice running, and
    not first, since learning starts at home. The movement after it starts at the home outcome.

    Parameters
    ----------
    targets : TargetSource
        Where the other movements go.
    home_action, home_outcome : array
        Home, shapes (m,) and (n,).
    home_probability : float
        Chance that a movement goes home.
    home_steps : int
        Steps of a movement home.
    """

    def __init__(
        self,
        targets: TargetSource,
        home_action: FloatArray,
        home_outcome: FloatArray,
        home_probability: float,
        home_steps: int,
    ) -> None:
        self._targets = targets
        self._home_action = home_action
        self._home_outcome = home_outcome
        self._home_probability = home_probability
        self._home_steps = home_steps
        self._home_path = np.empty((0, home_action.size))
        self._previous = home_outcome
        self._over = True
        self.going_home = True
        self.count = 0

    @property
    def target(self) -> FloatArray:
        """Target x*_t of the present step, shape (n,)."""
        return self._home_outcome if self.going_home else self._targets.target()

    @property
    def target_step(self) -> FloatArray:
        """Intended step x*_t - x*_{t-1}, shape (n,)."""
        return self.target - self._previous

    @property
    def goal_error(self) -> float:
        """Last known error of the goal under way, in the unit of outcomes; inf when unknown."""
        return self._targets.goal_error

    @property
    def resting(self) -> bool:
        """Whether the robot is to rest at a goal in the present step."""
        return not self.going_home and self._targets.resting

    @property
    def home_step(self) -> FloatArray:
        """Action of the present step of a movement home, shape (m,)."""
        action: FloatArray = self._home_path[0]
        return action

    def prepare(self, action: FloatArray, outcome: FloatArray, rng: np.random.Generator) -> None:
        """Start the next movement if the last one is over.

        Parameters
        ----------
        action, outcome : array
            Where the robot is, shapes (m,) and (n,).
        rng : numpy.random.Generator
            Source of all choices.
        """
        if not self._over:
            return
        self._over = False
        self.going_home = not self.going_home and rng.random() < self._home_probability
        if self.going_home:
            self._home_path = straight_line(action, self._home_action, self._home_steps)
        else:
            self._previous = self._targets.begin(self._previous, outcome, rng)

    def advance(self, outcome_step: FloatArray, outcome: FloatArray | None = None) -> bool:
        """Go on to the next step and return whether the movement is over.

        Parameters
        ----------
        outcome_step : array
            What the present step has brought, x_t - x_{t-1}, shape (n,).
        outcome : array, optional
            x_t, shape (n,); left out when what was observed is not to be trusted.
        """
        self._previous = self.target
        if self.going_home:
            self._home_path = self._home_path[1:]
            self._over = len(self._home_path) == 0
        else:
            self._over = self._targets.advance(outcome_step, outcome)
        self.count += self._over
        return self._over

    def state(self) -> SavedState:
        """Return what `load` and `restored_targets` need."""
        arrays = {"previous_target": self._previous, "home_path": self._home_path}
        settings = {
            "targets_kind": self._targets.kind,
            "going_home": self.going_home,
            "over": self._over,
            "count": self.count,
        }
        return SavedState(arrays, settings).joined(targets=self._targets.state())

    def load(self, state: SavedState) -> None:
        """Take over where the movements of a snapshot were."""
        self._previous = vector(
            "previous_target", state.arrays["previous_target"], self._home_outcome.size
        )
        self._home_path = matrix_or_empty(
            "home_path", state.arrays["home_path"], self._home_action.size
        )
        self._over = bool(state.settings["over"])
        self.going_home = bool(state.settings["going_home"])
        self.count = int(state.settings["count"])


def restored_targets(state: SavedState) -> TargetSource:
    """Return the source of targets that is part of a snapshot of `Movements`."""
    kind = state.settings["targets_kind"]
    if kind not in _RESTORE:
        raise InvalidConfigError(f"unknown targets {kind!r}; known are {', '.join(_RESTORE)}")
    return _RESTORE[kind](state.part("targets"))
