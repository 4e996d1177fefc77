"""What goal babbling asks of an inverse model g(x): whatever offers this can be learned with."""

from typing import Protocol, Self

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.saved_state import SavedState


class InverseModel(Protocol):
    """A function g from outcomes to actions that is learned from weighted examples.

    All arrays are in the normalised units of the learner (see `GoalBabblerConfig`).
    """

    kind: str
    """The model's name in checkpoints."""

    @property
    def count(self) -> int:
        """Number of local models."""
        ...

    def predict(self, outcome: FloatArray) -> FloatArray:
        """Return g at one outcome, shape (n,), as an action, shape (m,)."""
        ...

    def predict_many(self, outcomes: FloatArray) -> FloatArray:
        """Return g at many outcomes, shape (N, n), as actions, shape (N, m)."""
        ...

    def learn(self, outcome: FloatArray, action: FloatArray, weight: float) -> None:
        """Draw g(outcome) towards the action that caused it; weight is unit-free and positive."""
        ...

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        ...

    @classmethod
    def restore(cls, state: SavedState) -> Self:
        """Return the model whose snapshot this is; it continues bit for bit."""
        ...
