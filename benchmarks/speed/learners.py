"""The learners whose speed is measured: goal babbling on an arm with 20 joints."""

import math

import numpy as np

from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_babbler import CompiledGoalBabbler
from bha_goal_babbling.compiled_planar_arm import planar_arm_forward
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm

JOINTS = 20
USUAL, SMALL = 0.07, 0.0085  # reach d of a map [m]: about 150, and more than 10,000 maps

ARM = PlanarArm(JOINTS)
HOME = ARM.home()
LIMITS = np.full(JOINTS, math.pi)
FORWARD = planar_arm_forward()


def compiled_babbler(seed: int, distance: float = USUAL) -> CompiledGoalBabbler:
    """Return a fresh learner in machine code with a reach of its maps [m]."""
    return CompiledGoalBabbler(
        GoalBabblerConfig(map_distance=distance),
        ARM.goal_grid(),
        HOME,
        ARM.forward(HOME),
        -LIMITS,
        LIMITS,
        np.random.default_rng(seed),
        FORWARD,
    )


def numpy_babbler(seed: int) -> GoalBabbler:
    """Return a fresh learner of the reference."""
    return GoalBabbler(
        GoalBabblerConfig(),
        ARM.goal_grid(),
        HOME,
        ARM.forward(HOME),
        -LIMITS,
        LIMITS,
        np.random.default_rng(seed),
    )
