"""Movements to the goals that SAGG-RIAC chooses."""

import numpy as np

from benchmarks.methods.sagg_riac import SaggRiac
from bha_goal_babbling.arrays import FloatArray, vector
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.straight_walk import StraightWalk


class SaggRiacPaths:
    """Targets along straight lines between goals that SAGG-RIAC chooses; see `TargetSource`.

    Parameters
    ----------
    low, high : array
        Corners of the box of goals, shape (n,) [outcome unit].
    steps : int
        Number L of steps of a movement.
    seed : int
        Seed of the cuts of regions.
    """

    kind = "sagg_riac_paths"

    def __init__(self, low: FloatArray, high: FloatArray, steps: int, seed: int = 0) -> None:
        self._low, self._high = vector("low", low), vector("high", high)
        self._seed = seed
        self.choice = SaggRiac(self._low, self._high, np.random.default_rng(seed))
        self._reported: list[FloatArray] = []  # goal and error, shape (n + 1,)
        self._walk = StraightWalk(self.size, steps)
        self._outcome = np.zeros(self.size)

    @property
    def size(self) -> int:
        """Number n of coordinates of a target."""
        return int(self._low.size)

    @property
    def goal_error(self) -> float:
        """Last known error of the goal under way; every goal is a new one, so it is unknown."""
        return np.inf

    @property
    def resting(self) -> bool:
        """Never: one movement follows the other."""
        return False

    def begin(
        self, target: FloatArray, outcome: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Start a line from the last target to a goal."""
        self._walk.begin(target, self.choice.choose(rng))
        self._outcome = outcome.copy()
        return target

    def target(self) -> FloatArray:
        """Return the target of the present step, shape (n,)."""
        return self._walk.target

    def advance(self, outcome_step: FloatArray, outcome: FloatArray | None = None) -> bool:
        """Go on to the next step and return whether the goal was the last.

        Where the outcome is follows from its steps, so it need not be given.
        """
        self._outcome = self._outcome + outcome_step
        arrived = self._walk.advance()
        if arrived:
            goal = self._walk.goal.copy()
            self._report(goal, float(np.linalg.norm(self._outcome - goal)))
        return arrived

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {
            "low": self._low.copy(),
            "high": self._high.copy(),
            "reported": np.array(self._reported).reshape(-1, self.size + 1),
            "outcome": self._outcome.copy(),
        }
        return self._walk.saved_in(arrays, {"seed": self._seed})

    @classmethod
    def restore(cls, state: SavedState) -> "SaggRiacPaths":
        """Return the source whose snapshot this is: the same reports make the same regions."""
        arrays, settings = state.arrays, state.settings
        paths = cls(arrays["low"], arrays["high"], settings["steps"], settings["seed"])
        for row in arrays["reported"]:
            paths._report(row[:-1], float(row[-1]))
        paths._walk = StraightWalk.restored_from(state, paths.size)
        paths._outcome = arrays["outcome"].copy()
        return paths

    def _report(self, goal: FloatArray, error: float) -> None:
        self.choice.report(goal, error)
        self._reported.append(np.append(goal, error))
