"""Straight paths from goal to goal that keep account of how well each goal was met.

A path that has gone astray teaches little more: it is given up, and the next one starts at what
was observed. The error of every goal is remembered, and goals that were missed come more often.
A goal that was met before is rested at. What a robot on its way shows is not all that it does at
rest: it swings, and its cables with it, while at rest friction and weight hold them to one side.
"""

import numpy as np
from numpy.typing import ArrayLike

from bha_goal_babbling.arrays import FloatArray, matrix, vector
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_choice import LargestErrorChoice
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.straight_walk import StraightWalk


class MonitoredGoalPaths:
    """Targets along straight lines between goals of a finite set whose errors are known.

    Parameters
    ----------
    goals : array_like
        The goal set, in the unit of outcomes, shape (G, n) with G >= 2.
    steps : int
        Number L of steps of a movement.
    home_outcome : array_like
        Home, shape (n,). As learning starts with home everywhere, a goal's first error is its
        distance from home.
    candidates : int
        Number of goals drawn at random, of which the one with the largest last error comes next.
    abort_distance : float or None
        Distance between target and outcome from which on a path is given up, in the unit of
        outcomes; None never gives up.
    stay : int
        Number of steps for which a goal stays the target after a path has come to it: a robot
        that lags behind gets there, and its error is told of the goal itself.
    rest : int
        As many steps for a goal that was met before.
    rest_error : float
        Last error of a goal below which it counts as met, in the unit of outcomes; 0 rests at none.
    """

    kind = "monitored_goal_paths"

    def __init__(
        self,
        goals: ArrayLike,
        steps: int,
        home_outcome: ArrayLike,
        candidates: int = 3,
        abort_distance: float | None = None,
        stay: int = 0,
        rest: int = 0,
        rest_error: float = 0.0,
    ) -> None:
        self._goals = matrix("goals", goals)
        if len(self._goals) < 2:
            raise InvalidConfigError(f"the goal set must hold at least 2 goals, got {self._goals}")
        if abort_distance is not None and not abort_distance > 0:
            raise InvalidConfigError(f"abort_distance must be above 0 or None: {abort_distance}")
        if stay < 0 or rest < 0 or not rest_error >= 0:
            raise InvalidConfigError(
                "stay, rest and rest_error must not be negative, "
                f"got {stay}, {rest} and {rest_error}"
            )
        home = vector("home_outcome", home_outcome, self.size)
        self._errors: FloatArray = np.linalg.norm(self._goals - home, axis=1)
        self._choice = LargestErrorChoice(candidates)
        self._candidates = candidates
        self._abort_distance = abort_distance
        self._stay, self._rest, self._rest_error = stay, rest, rest_error
        self._walk = StraightWalk(self.size, steps)
        self._aborted = False

    @property
    def size(self) -> int:
        """Number n of coordinates of a target."""
        return int(self._goals.shape[1])

    @property
    def goals(self) -> FloatArray:
        """The goal set, shape (G, n), a copy."""
        return self._goals.copy()

    @property
    def errors(self) -> FloatArray:
        """Last error of every goal, in the unit of outcomes, shape (G,), a copy."""
        return self._errors.copy()

    @property
    def goal_error(self) -> float:
        """Last error of the goal under way, in the unit of outcomes."""
        return float(self._errors[self._choice.last])

    @property
    def resting(self) -> bool:
        """Whether the present step is one of rest at a goal that was met before."""
        return self._walk.stays and self._met

    def begin(
        self, target: FloatArray, outcome: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Start a line to a goal, from the last target or, after giving up, the last outcome."""
        start = outcome if self._aborted else target
        goal = self._goals[self._choice.choose(self._errors, rng)]
        self._walk.begin(start, goal, self._rest if self._met else self._stay)
        self._aborted = False
        return start

    def target(self) -> FloatArray:
        """Return the target of the present step, shape (n,)."""
        return self._walk.target

    def advance(self, outcome_step: FloatArray, outcome: FloatArray | None = None) -> bool:
        """Go on to the next step and return whether the goal was the last or the path given up."""
        error = np.inf if outcome is None else float(np.linalg.norm(outcome - self.target()))
        arrived = self._walk.advance()
        self._aborted = (
            outcome is not None
            and self._abort_distance is not None
            and error > self._abort_distance
        )
        if outcome is not None and (arrived or self._aborted):
            self._errors[self._choice.last] = error
        return arrived or self._aborted

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {"goals": self.goals, "errors": self.errors}
        settings = {
            "candidates": self._candidates,
            "abort_distance": self._abort_distance,
            "stay": self._stay,
            "rest": self._rest,
            "rest_error": self._rest_error,
            "last_goal": self._choice.last,
            "aborted": self._aborted,
        }
        return self._walk.saved_in(arrays, settings)

    @classmethod
    def restore(cls, state: SavedState) -> "MonitoredGoalPaths":
        """Return the source whose snapshot this is."""
        arrays, settings = state.arrays, state.settings
        goals = matrix("goals", arrays["goals"])
        paths = cls(
            goals,
            int(settings["steps"]),
            goals[0],
            int(settings["candidates"]),
            settings["abort_distance"],
            int(settings["stay"]),
            int(settings["rest"]),
            float(settings["rest_error"]),
        )
        paths._errors = vector("errors", arrays["errors"], len(goals))
        last = int(settings["last_goal"])
        if not -1 <= last < len(goals):
            raise InvalidConfigError(f"there are {len(goals)} goals, the last is {last}")
        paths._walk = StraightWalk.restored_from(state, paths.size)
        paths._choice = LargestErrorChoice(paths._candidates, last)
        paths._aborted = bool(settings["aborted"])
        return paths

    @property
    def _met(self) -> bool:
        """Whether the goal under way was met before; it is known anew only when it is over."""
        return self.goal_error < self._rest_error
