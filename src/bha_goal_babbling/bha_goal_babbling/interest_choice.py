"""Goals chosen by interest: where the error is large, and where it is changing.

    interest = a RE + (1 - a) (b PROG + (1 - b) REG)

RE is a goal's error lately, PROG by how much it has fallen, REG by how much it has risen, each as a
share of the largest among all goals (interest measurement of Rayyes, Donat and Steil,
"Hierarchical interest-driven goal babbling for efficient bootstrapping of sensorimotor skills",
2020). Errors are those of a goal's last visits; the older half of them is compared with the newer.
"""

import numpy as np
from numpy.typing import ArrayLike

from bha_goal_babbling.arrays import FloatArray, matrix
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_paths import matrix_or_empty, straight_line
from bha_goal_babbling.saved_state import SavedState


class InterestGoalChoice:
    """Draws indices of goals in proportion to their interest, never the last one again.

    A goal that was never visited has the largest RE, 1, and neither PROG nor REG.

    Parameters
    ----------
    count : int
        Number of goals, at least 2.
    window : int
        Number of last visits of a goal that count, at least 2.
    error_share : float
        Share a of the error in the interest, in 0 to 1.
    progress_share : float
        Share b of progress against regress, in 0 to 1.
    """

    def __init__(
        self, count: int, window: int = 12, error_share: float = 0.5, progress_share: float = 0.5
    ) -> None:
        if count < 2 or window < 2:
            raise InvalidConfigError(
                f"count and window must be at least 2, got {count} goals and a window of {window}"
            )
        if not (0.0 <= error_share <= 1.0 and 0.0 <= progress_share <= 1.0):
            raise InvalidConfigError(
                f"shares must be in 0 to 1, got {error_share} and {progress_share}"
            )
        self._error_share = float(error_share)
        self._progress_share = float(progress_share)
        # The last errors of each goal, the newest in the last column; NaN where there was none.
        self._errors = np.full((count, window), np.nan)
        self.last = -1

    def report(self, goal: int, error: float) -> None:
        """Take the error with which a goal was reached [outcome unit]."""
        self._errors[goal, :-1] = self._errors[goal, 1:]
        self._errors[goal, -1] = error

    def last_error(self, goal: int) -> float:
        """Return the error with which a goal was reached last; inf when it never was."""
        error = float(self._errors[goal, -1])
        return error if np.isfinite(error) else np.inf

    def interest(self) -> FloatArray:
        """Return the interest of every goal, in 0 to 1, shape (G,)."""
        window = self._errors.shape[1]
        visits = np.isfinite(self._errors).sum(axis=1)
        errors = np.nan_to_num(self._errors)
        newer_count = visits - visits // 2
        newer = np.arange(window) >= window - newer_count[:, np.newaxis]
        newer_mean = (errors * newer).sum(axis=1) / np.maximum(newer_count, 1)
        # Zeros stand where there was no visit, so they add nothing to the sum.
        older_mean = (errors * ~newer).sum(axis=1) / np.maximum(visits // 2, 1)
        fallen = np.where(visits >= 2, older_mean - newer_mean, 0.0)
        error = np.where(visits > 0, _share_of_largest(newer_mean), 1.0)
        progress = _share_of_largest(np.maximum(fallen, 0.0))
        regress = _share_of_largest(np.maximum(-fallen, 0.0))
        changing = self._progress_share * progress + (1.0 - self._progress_share) * regress
        interest: FloatArray = self._error_share * error + (1.0 - self._error_share) * changing
        return interest

    def choose(self, rng: np.random.Generator) -> int:
        """Return the index of the next goal."""
        interest = self.interest()
        if self.last >= 0:
            interest[self.last] = 0.0
        if not interest.any():
            # Nothing is of interest; then all but the last are alike.
            interest = (np.arange(len(interest)) != self.last).astype(float)
        self.last = int(rng.choice(len(interest), p=interest / interest.sum()))
        return self.last

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        settings = {
            "window": self._errors.shape[1],
            "error_share": self._error_share,
            "progress_share": self._progress_share,
            "last": self.last,
        }
        return SavedState({"errors": self._errors.copy()}, settings)

    @classmethod
    def restore(cls, state: SavedState) -> "InterestGoalChoice":
        """Return the choice whose snapshot this is."""
        errors, settings = state.arrays["errors"], state.settings
        choice = cls(
            len(errors),
            int(settings["window"]),
            float(settings["error_share"]),
            float(settings["progress_share"]),
        )
        last = int(settings["last"])
        if errors.shape != choice._errors.shape or not -1 <= last < len(errors):
            raise InvalidConfigError(
                f"errors have shape {errors.shape}, expected {choice._errors.shape}; last is {last}"
            )
        choice._errors = errors.copy()
        choice.last = last
        return choice


class InterestPaths:
    """Targets along straight lines between goals of a finite set, chosen by interest.

    Parameters
    ----------
    goals : array_like
        The goal set, in the unit of outcomes, shape (G, n) with G >= 2.
    steps : int
        Number L of steps of a movement.
    choice : InterestGoalChoice, optional
        What chooses among as many goals; one with its own defaults if none is given.
    """

    kind = "interest_paths"

    def __init__(
        self, goals: ArrayLike, steps: int, choice: InterestGoalChoice | None = None
    ) -> None:
        self._goals = matrix("goals", goals)
        if steps < 1:
            raise InvalidConfigError(f"a movement needs at least 1 step, got {steps}")
        self._choice = InterestGoalChoice(len(self._goals)) if choice is None else choice
        self._steps = steps
        self._path = np.empty((0, self.size))
        self._next = 0
        self._outcome = np.zeros(self.size)

    @property
    def size(self) -> int:
        """Number n of coordinates of a target."""
        return int(self._goals.shape[1])

    @property
    def goal_error(self) -> float:
        """Last known error of the goal under way, in the unit of outcomes; inf when unknown."""
        return self._choice.last_error(self._choice.last)

    def begin(
        self, target: FloatArray, outcome: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Start a line from the last target to a goal; see `TargetSource`."""
        goal = self._goals[self._choice.choose(rng)]
        self._path = straight_line(target, goal, self._steps)
        self._next = 0
        self._outcome = outcome.copy()
        return target

    def target(self) -> FloatArray:
        """Return the target of the present step, shape (n,)."""
        point: FloatArray = self._path[self._next]
        return point

    def advance(self, outcome_step: FloatArray, outcome: FloatArray | None = None) -> bool:
        """Go on to the next step and return whether the goal was the last.

        Where the outcome is follows from its steps, so it need not be given.
        """
        self._outcome = self._outcome + outcome_step
        self._next += 1
        if self._next < len(self._path):
            return False
        error = float(np.linalg.norm(self._outcome - self._path[-1]))
        self._choice.report(self._choice.last, error)
        return True

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {
            "goals": self._goals.copy(),
            "path": self._path.copy(),
            "outcome": self._outcome.copy(),
        }
        settings = {"steps": self._steps, "next": self._next}
        return SavedState(arrays, settings).joined(choice=self._choice.state())

    @classmethod
    def restore(cls, state: SavedState) -> "InterestPaths":
        """Return the source whose snapshot this is."""
        choice = InterestGoalChoice.restore(state.part("choice"))
        paths = cls(state.arrays["goals"], int(state.settings["steps"]), choice)
        paths._path = matrix_or_empty(state.arrays["path"], paths.size)
        paths._outcome = state.arrays["outcome"].copy()
        paths._next = int(state.settings["next"])
        if not 0 <= paths._next <= len(paths._path):
            raise InvalidConfigError(f"path has {len(paths._path)} steps, next is {paths._next}")
        return paths


def _share_of_largest(values: FloatArray) -> FloatArray:
    """Return values, at least 0, shape (G,), divided by the largest; zeros stay zeros."""
    largest = values.max()
    shares: FloatArray = values / largest if largest > 0.0 else values
    return shares
