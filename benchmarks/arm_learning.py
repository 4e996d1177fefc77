"""Goal babbling on planar arms, as the tables need it."""

import math

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm


class ArmLearning:
    """A planar arm, limits +-pi, and goal babbling on it.

    Parameters
    ----------
    joints : int
        Number m of joints.
    config : GoalBabblerConfig
        All settings.
    rng : numpy.random.Generator
        Source of all randomness.
    branch : int
        Side of the arch at home, +1 or -1 (see `PlanarArm.home`).
    """

    def __init__(
        self, joints: int, config: GoalBabblerConfig, rng: np.random.Generator, branch: int = 1
    ) -> None:
        self.arm = PlanarArm(joints)
        self.goals = self.arm.goal_grid()
        self.home = self.arm.home(branch=branch)
        limits = np.full(joints, math.pi)
        self.babbler = GoalBabbler(
            config, self.goals, self.home, self.arm.forward(self.home), -limits, limits, rng
        )

    def babble(self, movements: int) -> None:
        """Go on until so many movements are over, counted from the beginning."""
        babbler, forward = self.babbler, self.arm.forward
        while babbler.movements < movements:
            action = babbler.ask()
            babbler.tell(action, forward(action))

    def postures(self) -> FloatArray:
        """Return g at the goals [rad], shape (G, m)."""
        return self.babbler.inverse(self.goals)

    def errors(self) -> FloatArray:
        """Return how far the tip stays from each goal, without noise [m], shape (G,)."""
        return reaching_errors(self.arm, self.postures(), self.goals)


def reaching_errors(arm: PlanarArm, postures: FloatArray, goals: FloatArray) -> FloatArray:
    """Return the distances of tips and goals [m], shape (G,), of postures of shape (G, m)."""
    distances: FloatArray = np.linalg.norm(arm.forward(postures) - goals, axis=1)
    return distances
