"""Goal babbling in machine code on the reaching task of the tables."""

import numpy as np

from benchmarks.arm.reaching import ReachingTask
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_babbler import CompiledGoalBabbler
from bha_goal_babbling.compiled_planar_arm import planar_arm_forward
from bha_goal_babbling.direction_sampling import DirectionTargets

_FORWARD = planar_arm_forward()


def compiled_babbler(
    task: ReachingTask,
    config: GoalBabblerConfig,
    seed: int,
    targets: FloatArray | DirectionTargets | None = None,
) -> CompiledGoalBabbler:
    """Return a learner that has not begun; its goals are the task's if no others are given."""
    return CompiledGoalBabbler(
        config,
        task.goals if targets is None else targets,
        task.home_action,
        task.home_outcome,
        -task.limits,
        task.limits,
        np.random.default_rng(seed),
        _FORWARD,
    )
