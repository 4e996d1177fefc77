"""The one interface of all compared methods."""

from abc import ABC, abstractmethod

from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray


class Method(ABC):
    """Learns to reach goals by acting in a world.

    Parameters
    ----------
    world : World
        Where it acts.
    """

    def __init__(self, world: World) -> None:
        self.world = world

    @property
    def samples(self) -> int:
        """Number of executed actions."""
        return self.world.samples

    @abstractmethod
    def step(self) -> None:
        """Execute exactly one action, and learn from it."""

    def run(self, samples: int) -> None:
        """Execute a number of actions."""
        for _ in range(samples):
            self.step()

    @abstractmethod
    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return the actions for goals, shape (G, n), without noise and without acting: (G, m).

        Before anything was learned that is the home action.
        """
