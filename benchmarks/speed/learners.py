"""The learners whose speed is measured: goal babbling on an arm with 20 joints."""

import dataclasses

import numpy as np

from benchmarks import compiled_arm
from bha_goal_babbling.compiled_babbler import CompiledGoalBabbler
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm

JOINTS = 20
USUAL, SMALL = 0.07, 0.0085  # reach d of a map [m]: about 150, and more than 10,000 maps

ARM = PlanarArm(JOINTS)


def compiled_babbler(seed: int, distance: float = USUAL) -> CompiledGoalBabbler:
    """Return a fresh learner in machine code with a reach of its maps [m]."""
    config = dataclasses.replace(compiled_arm.FAST, map_distance=distance)
    return compiled_arm.compiled_babbler(ARM, config, seed)


def numpy_babbler(seed: int) -> GoalBabbler:
    """Return a fresh learner of the reference."""
    home, limits = ARM.home(), np.full(JOINTS, compiled_arm.LIMIT)
    rng = np.random.default_rng(seed)
    return GoalBabbler(
        compiled_arm.FAST, ARM.goal_grid(), home, ARM.forward(home), -limits, limits, rng
    )
