"""Goals chosen by interest: where the error is large, and where it is changing.

    interest = a RE + (1 - a) (b PROG + (1 - b) REG)

RE is a goal's error lately, PROG by how much it has fallen, REG by how much it has risen, each as a
share of the largest among all goals (interest measurement of Rayyes, Donat and Steil,
"Hierarchical interest-driven goal babbling for efficient bootstrapping of sensorimotor skills",
2020). Errors are those of a goal's last visits; the older half of them is compared with the newer.
"""

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import InvalidConfigError
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


def _share_of_largest(values: FloatArray) -> FloatArray:
    """Return values, at least 0, shape (G,), divided by the largest; zeros stay zeros."""
    largest = values.max()
    shares: FloatArray = values / largest if largest > 0.0 else values
    return shares
