"""The compiled learner of the tables, as the speed suite makes it: from an arm."""

from benchmarks import compiled_reaching
from benchmarks.configs import FAST as FAST
from benchmarks.reaching import LIMIT as LIMIT
from benchmarks.reaching import ReachingTask
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_babbler import CompiledGoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm


def compiled_babbler(arm: PlanarArm, config: GoalBabblerConfig, seed: int) -> CompiledGoalBabbler:
    """Return a learner that has not begun on the reaching task of an arm of 1 m."""
    return compiled_reaching.compiled_babbler(ReachingTask(arm.joints), config, seed)
