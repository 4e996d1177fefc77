"""The methods that the table `baselines` compares, each with its settings.

The settings were tried out by hand on seeds 0 to 2, with 1,000 to 3,000 samples on 2, 20 and 50
joints, and are the same for all arms, up to the factor 1 / sqrt(m) where random angles add up.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.arm.configs import ARTICLE, FAST, RLS
from benchmarks.methods.differential_inverse import DifferentialInverse
from benchmarks.methods.direct_fit import DirectFit
from benchmarks.methods.distal_teacher import DistalTeacher
from benchmarks.methods.feedback_error import FeedbackErrorLearning, inverse_jacobian
from benchmarks.methods.forward_model import ForwardModelSettings
from benchmarks.methods.goal_babbling import GoalBabbling
from benchmarks.methods.method import Method
from benchmarks.methods.motor_babbling import MotorBabbling
from benchmarks.methods.nearest_neighbour import NearestNeighbour
from benchmarks.methods.null_space_home import NullSpaceHome
from benchmarks.methods.reward_weighted import RewardWeightedRegression
from benchmarks.methods.world import World
from bha_goal_babbling.planar_arm import PlanarArm

_FULL_RANGE = 2.0 * math.pi
"""Spread of motor babbling that fills the limits wherever home is [rad]."""


@dataclass(frozen=True)
class Contender:
    """A method with its settings.

    Attributes
    ----------
    make : Makes it for an arm, the world on it, and a generator.
    ours : Whether it is goal babbling as this project does it.
    knows_jacobian : Whether it is given the Jacobian of the arm.
    """

    make: Callable[[PlanarArm, World, np.random.Generator], Method]
    ours: bool = False
    knows_jacobian: bool = False


def _share(arm: PlanarArm, angle: float) -> float:
    """Return an angle [rad] of which m random ones add up to about the same heading."""
    return angle / math.sqrt(arm.joints)


METHODS: dict[str, Contender] = {
    "goal babbling (article)": Contender(
        lambda arm, world, rng: GoalBabbling(world, rng, ARTICLE), ours=True
    ),
    "goal babbling (fast)": Contender(
        lambda arm, world, rng: GoalBabbling(world, rng, FAST), ours=True
    ),
    "motor babbling, all angles": Contender(
        lambda arm, world, rng: MotorBabbling(world, rng, spread=_FULL_RANGE)
    ),
    "motor babbling, near home": Contender(
        lambda arm, world, rng: MotorBabbling(
            world, rng, spread=_share(arm, 1.4), forward_model=ForwardModelSettings(waves=1000)
        )
    ),
    "null-space home": Contender(
        lambda arm, world, rng: NullSpaceHome(
            world, rng, forward_model=ForwardModelSettings(length=0.7)
        )
    ),
    "differential inverse": Contender(
        lambda arm, world, rng: DifferentialInverse(
            world,
            rng,
            spread=_share(arm, 0.7),
            walk_step=_share(arm, 0.4),
            outcome_reach=0.05,
            action_reach=_share(arm, 1.0),
        )
    ),
    "feedback-error learning": Contender(
        lambda arm, world, rng: FeedbackErrorLearning(
            world, rng, inverse_jacobian(arm.jacobian), steps=2
        ),
        knows_jacobian=True,
    ),
    "distal teacher": Contender(
        lambda arm, world, rng: DistalTeacher(
            world,
            rng,
            babbling=30,
            spread=_share(arm, 1.4),
            path_steps=2,
            distance=0.3,
            forward_model=ForwardModelSettings(waves=300),
        )
    ),
    "reward-weighted regression": Contender(
        lambda arm, world, rng: RewardWeightedRegression(
            world,
            rng,
            exploration=_share(arm, 0.9),
            batch=100,
            window=400,
            ridge=0.1,
            distance=0.3,
        )
    ),
    "direct fit, all angles": Contender(
        lambda arm, world, rng: DirectFit(world, rng, spread=_FULL_RANGE, distance=0.4)
    ),
    "direct fit, near home": Contender(
        lambda arm, world, rng: DirectFit(world, rng, spread=_share(arm, 1.4), distance=0.4)
    ),
    "nearest neighbour": Contender(
        lambda arm, world, rng: NearestNeighbour(world, rng, exploration=_share(arm, 0.4))
    ),
    "RLS goal babbling": Contender(
        lambda arm, world, rng: GoalBabbling(world, rng, RLS), ours=True
    ),
}
"""All compared methods by name."""
