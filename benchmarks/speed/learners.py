"""The learners whose speed is measured: goal babbling on an arm with 20 joints."""

import dataclasses

from benchmarks.arm import compiled_reaching
from benchmarks.arm.configs import FAST
from benchmarks.arm.reaching import ReachingTask
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_babbler import CompiledGoalBabbler

TASK = ReachingTask(20)
SMALL = 0.0085  # reach d of a map [m] with which there come to be 10,000; usually there are 150


def compiled_babbler(seed: int, config: GoalBabblerConfig = FAST) -> CompiledGoalBabbler:
    """Return a fresh learner in machine code."""
    return compiled_reaching.compiled_babbler(TASK, config, seed)


def with_maps(distance: float) -> GoalBabblerConfig:
    """Return settings with another reach d of the maps [m], all else as usual."""
    return dataclasses.replace(FAST, map_distance=distance)


def in_proportion(distance: float) -> GoalBabblerConfig:
    """Return settings with another reach d of the maps [m], noise and steps of a path to match."""
    scale = distance / FAST.map_distance
    return dataclasses.replace(
        with_maps(distance),
        path_steps=round(FAST.path_steps / scale),
        noise_spread=FAST.noise_spread * scale,
        noise_step=FAST.noise_step * scale,
    )
