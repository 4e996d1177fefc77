"""Goal babbling in machine code on planar arms of 1 m: goals, home and limits of the tables."""

import math

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_babbler import CompiledGoalBabbler
from bha_goal_babbling.compiled_planar_arm import planar_arm_forward
from bha_goal_babbling.direction_sampling import DirectionTargets
from bha_goal_babbling.planar_arm import PlanarArm

LIMIT = math.pi
"""Joints turn by plus and minus this [rad]."""

ARTICLE = GoalBabblerConfig(map_distance=0.1, learning_rate=0.1, noise_spread=0.05, noise_step=0.01)
"""The article's slow noise and small steps."""

FAST = GoalBabblerConfig()
"""Fresh noise and large steps: fast and accurate."""

_FORWARD = planar_arm_forward()


def compiled_babbler(
    arm: PlanarArm,
    config: GoalBabblerConfig,
    seed: int,
    targets: FloatArray | DirectionTargets | None = None,
    branch: int = 1,
) -> CompiledGoalBabbler:
    """Return a learner that has not begun; its goals are the grid if no others are given.

    The branch is the side of the arch at home, +1 or -1 (see `PlanarArm.home`).
    """
    home, limits = arm.home(branch=branch), np.full(arm.joints, LIMIT)
    return CompiledGoalBabbler(
        config,
        arm.goal_grid() if targets is None else targets,
        home,
        arm.forward(home),
        -limits,
        limits,
        np.random.default_rng(seed),
        _FORWARD,
    )


def reaching_errors(arm: PlanarArm, postures: FloatArray) -> FloatArray:
    """Return the distances of tips from the goals of the grid [m], shape (G,).

    Parameters
    ----------
    arm : The arm.
    postures : Answers to the goals [rad], shape (G, m).
    """
    errors: FloatArray = np.linalg.norm(arm.forward(postures) - arm.goal_grid(), axis=1)
    return errors
