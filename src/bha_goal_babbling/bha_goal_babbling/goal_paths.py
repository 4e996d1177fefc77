"""Targets along straight lines from goal to goal of a finite set."""

import numpy as np
from numpy.typing import ArrayLike

from bha_goal_babbling.arrays import FloatArray, matrix, vector
from bha_goal_babbling.goal_choice import RandomGoalChoice
from bha_goal_babbling.interest_choice import InterestGoalChoice
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.straight_walk import StraightWalk


class GoalPaths:
    """Straight lines between goals; what chooses the next goal is told how the last was reached.

    Parameters
    ----------
    goals : array_like
        The goal set, in the unit of outcomes, shape (G, n) with G >= 2.
    steps : int
        Number L of steps of a movement.
    choice : RandomGoalChoice or InterestGoalChoice, optional
        What chooses among as many goals; at random if it is not given.
    """

    kind = "goal_paths"

    def __init__(
        self,
        goals: ArrayLike,
        steps: int,
        choice: RandomGoalChoice | InterestGoalChoice | None = None,
    ) -> None:
        self._goals = matrix("goals", goals)
        self._choice = RandomGoalChoice(len(self._goals)) if choice is None else choice
        self._walk = StraightWalk(self.size, steps)
        self._outcome = np.zeros(self.size)

    @property
    def size(self) -> int:
        """Number n of coordinates of a target."""
        return int(self._goals.shape[1])

    @property
    def goals(self) -> FloatArray:
        """The goal set, shape (G, n), a copy."""
        return self._goals.copy()

    @property
    def goal_error(self) -> float:
        """Last known error of the goal under way, in the unit of outcomes; inf when unknown."""
        return self._choice.last_error(self._choice.last)

    @property
    def resting(self) -> bool:
        """Never: one movement follows the other."""
        return False

    def begin(
        self, target: FloatArray, outcome: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Start a line from the last target to a goal; see `TargetSource`."""
        self._walk.begin(target, self._goals[self._choice.choose(rng)])
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
            error = float(np.linalg.norm(self._outcome - self._walk.goal))
            self._choice.report(self._choice.last, error)
        return arrived

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        if isinstance(self._choice, RandomGoalChoice):
            return self._walk.saved_in({"goals": self.goals}, {"last_goal": self._choice.last})
        arrays = {"goals": self.goals, "outcome": self._outcome.copy()}
        return self._walk.saved_in(arrays).joined(choice=self._choice.state())

    @classmethod
    def restore(cls, state: SavedState) -> "GoalPaths":
        """Return the source whose snapshot this is."""
        goals, settings = state.arrays["goals"], state.settings
        steps = int(settings["steps"])
        if "last_goal" in settings:
            paths = cls(goals, steps, RandomGoalChoice(len(goals), int(settings["last_goal"])))
        else:
            paths = cls(goals, steps, InterestGoalChoice.restore(state.part("choice")))
            paths._outcome = vector("outcome", state.arrays["outcome"], paths.size)
        paths._walk = StraightWalk.restored_from(state, paths.size)
        return paths
