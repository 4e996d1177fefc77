"""What goal babbling asks of a source of targets x*_t, one movement after the other."""

from typing import Protocol, Self, runtime_checkable

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.saved_state import SavedState


@runtime_checkable
class TargetSource(Protocol):
    """Cuts the intentions of the learner into movements, and movements into steps.

    Targets are in the unit of outcomes, shape (n,).
    """

    kind: str
    """The source's name in checkpoints."""

    @property
    def size(self) -> int:
        """Number n of coordinates of a target."""
        ...

    def begin(
        self, target: FloatArray, outcome: FloatArray, rng: np.random.Generator
    ) -> FloatArray:
        """Start a movement and return the point from which its first step is counted.

        Parameters
        ----------
        target : array
            Last target of the movement before, shape (n,).
        outcome : array
            Last observed outcome, shape (n,).
        rng : numpy.random.Generator
            Source of all choices.
        """
        ...

    def target(self) -> FloatArray:
        """Return the target of the present step."""
        ...

    @property
    def goal_error(self) -> float:
        """Last known error of the goal under way, in the unit of outcomes; inf when unknown."""
        ...

    @property
    def resting(self) -> bool:
        """Whether the robot is to rest at the goal in the present step, to show what comes then."""
        ...

    def advance(self, outcome_step: FloatArray, outcome: FloatArray | None = None) -> bool:
        """Go on to the next step and return whether there is none, the movement being over.

        Parameters
        ----------
        outcome_step : array
            What the present step has brought, x_t - x_{t-1}, shape (n,).
        outcome : array, optional
            x_t, shape (n,); left out when what was observed is not to be trusted.
        """
        ...

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        ...

    @classmethod
    def restore(cls, state: SavedState) -> Self:
        """Return the source whose snapshot this is."""
        ...
