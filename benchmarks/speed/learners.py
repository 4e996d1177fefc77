"""The learners whose speed is measured: goal babbling on an arm with 20 joints."""

import dataclasses

import numpy as np

from benchmarks import compiled_arm
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_babbler import CompiledGoalBabbler
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm

JOINTS = 20
SMALL = 0.0085  # reach d of a map [m] with which there come to be 10,000; usually there are 150

ARM = PlanarArm(JOINTS)


def compiled_babbler(
    seed: int, config: GoalBabblerConfig = compiled_arm.FAST
) -> CompiledGoalBabbler:
    """Return a fresh learner in machine code."""
    return compiled_arm.compiled_babbler(ARM, config, seed)


def with_maps(distance: float) -> GoalBabblerConfig:
    """Return settings with another reach d of the maps [m], all else as usual."""
    return dataclasses.replace(compiled_arm.FAST, map_distance=distance)


def in_proportion(distance: float) -> GoalBabblerConfig:
    """Return settings with another reach d of the maps [m], noise and steps of a path to match."""
    scale = distance / compiled_arm.FAST.map_distance
    return dataclasses.replace(
        with_maps(distance),
        path_steps=round(compiled_arm.FAST.path_steps / scale),
        noise_spread=compiled_arm.FAST.noise_spread * scale,
        noise_step=compiled_arm.FAST.noise_step * scale,
    )


def numpy_babbler(seed: int) -> GoalBabbler:
    """Return a fresh learner of the reference."""
    home, limits = ARM.home(), np.full(JOINTS, compiled_arm.LIMIT)
    rng = np.random.default_rng(seed)
    return GoalBabbler(
        compiled_arm.FAST, ARM.goal_grid(), home, ARM.forward(home), -limits, limits, rng
    )
