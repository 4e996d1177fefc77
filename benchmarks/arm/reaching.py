"""The reaching task that the tables on planar arms share, and how long a learner takes with it.

The arm is 1 m long, with m equal links. Goals are a grid of 10 cm in x 0.2 to 0.8 m and y -0.5 to
0.5 m; home is an even arch with the tip at (0.7, 0) m; joints turn by +-pi.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm

LIMIT = math.pi
"""Joints turn by plus and minus this [rad]."""


class ReachingTask:
    """An arm with goals [m], shape (G, 2), home and limits [rad], shapes (m,).

    Parameters
    ----------
    joints : int
        Number m of joints.
    branch : int
        Side of the arch at home: +1 above the x axis, -1 below.
    """

    def __init__(self, joints: int, branch: int = 1) -> None:
        self.arm = PlanarArm(joints)
        self.goals = self.arm.goal_grid()
        self.home_action = self.arm.home(branch=branch)
        self.home_outcome = self.arm.forward(self.home_action)
        self.limits = np.full(joints, LIMIT)

    def babbler(self, config: GoalBabblerConfig, seed: int) -> GoalBabbler:
        """Return a learner in numpy that has not begun; see also `compiled_reaching`."""
        return GoalBabbler(
            config,
            self.goals,
            self.home_action,
            self.home_outcome,
            -self.limits,
            self.limits,
            np.random.default_rng(seed),
        )

    def errors(self, inverse: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Return the distances of noise-free reaches from the goals [m], shape (G,)."""
        return self.errors_of(inverse(self.goals))

    def errors_of(self, postures: FloatArray) -> FloatArray:
        """Return the distances of tips from the goals [m], shape (G,).

        Parameters
        ----------
        postures : Answers to the goals [rad], shape (G, m).
        """
        errors: FloatArray = np.linalg.norm(self.arm.forward(postures) - self.goals, axis=1)
        return errors


@dataclass(frozen=True)
class TimeToReach:
    """What it took until the error was down; None for a run in which it never was.

    Attributes
    ----------
    samples : Samples executed.
    movements : Movements finished, those towards home counted too.
    """

    samples: int | None
    movements: int | None


def time_to_reach(
    task: ReachingTask,
    babbler: GoalBabbler,
    *,
    share: float = 0.1,
    most_samples: int | None = None,
    most_movements: int | None = None,
    every_sample: bool = False,
) -> TimeToReach:
    """Learn until the mean error over the goals is down to a share of what it was at first.

    Parameters
    ----------
    task : What is learned.
    babbler : The learner.
    share : Share of the first error.
    most_samples, most_movements : When to stop in any case, at least one of them.
    every_sample : Look at the error after every sample; otherwise at the ends of movements.
    """
    if most_samples is None and most_movements is None:
        raise ValueError("a run needs most_samples or most_movements to end")
    samples = math.inf if most_samples is None else most_samples
    movements = math.inf if most_movements is None else most_movements
    enough = share * task.errors(babbler.inverse).mean()
    while babbler.samples < samples and babbler.movements < movements:
        finished = babbler.movements
        action = babbler.ask()
        babbler.tell(action, task.arm.forward(action))
        look = every_sample or babbler.movements > finished
        if look and task.errors(babbler.inverse).mean() <= enough:
            return TimeToReach(babbler.samples, babbler.movements)
    return TimeToReach(None, None)
