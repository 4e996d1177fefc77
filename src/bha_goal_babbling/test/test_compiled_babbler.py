"""The loop in machine code against the reference, sample by sample."""

import math

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_babbler import CompiledGoalBabbler
from bha_goal_babbling.compiled_planar_arm import planar_arm_forward
from bha_goal_babbling.direction_sampling import DirectionTargets
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm

FORWARD = planar_arm_forward()
SLOW = GoalBabblerConfig(map_distance=0.1, learning_rate=0.1, noise_spread=0.05, noise_step=0.01)
FAST = GoalBabblerConfig()
SCALED = GoalBabblerConfig(
    action_scale=2.0,
    outcome_scale=0.5,
    efficiency="relative",
    efficiency_limit=2.0,
    noise_origin="home",
    action_resolution=0.005,
    outcome_resolution=0.001,
    path_steps=7,
    learning_rate=0.1,
)
UNWEIGHTED = GoalBabblerConfig(direction="none", efficiency="none", learning_rate=0.3)


def twins(
    joints: int, config: GoalBabblerConfig, *, directions: bool, cutoff: float = 0.0, seed: int = 0
) -> tuple[PlanarArm, GoalBabbler, CompiledGoalBabbler]:
    """Return an arm, the reference on it, and the same in machine code."""
    arm = PlanarArm(joints)
    home = arm.home()
    # Folded to exactly pi the tip of two links is at the base up to rounding, which then alone
    # decides about directions.
    limits = np.full(joints, 3.0)
    goals = DirectionTargets(0.02, 2) if directions else arm.goal_grid()
    task = (config, goals, home, arm.forward(home), -limits, limits)
    reference = GoalBabbler(*task, np.random.default_rng(seed))
    ours = CompiledGoalBabbler(*task, np.random.default_rng(seed), FORWARD, cutoff=cutoff)
    return arm, reference, ours


def outcomes(arm: PlanarArm, babbler: GoalBabbler, samples: int) -> FloatArray:
    """Babble with the reference; the outcomes [m], shape (samples, 2)."""
    tips = np.empty((samples, 2))
    for tip in tips:
        action = babbler.ask()
        tip[:] = arm.forward(action)
        babbler.tell(action, tip)
    return tips


@pytest.mark.parametrize("joints", [2, 5, 20])
@pytest.mark.parametrize(
    "config", [SLOW, FAST, SCALED, UNWEIGHTED], ids=["slow", "fast", "scaled", "unweighted"]
)
@pytest.mark.parametrize("directions", [False, True], ids=["paths", "directions"])
def test_the_loop_is_the_reference(
    joints: int, config: GoalBabblerConfig, directions: bool
) -> None:
    """Thousands of samples agree to 1e-11 of the arm's length, in the same movements.

    Rounding grows faster along directions, which hit the limits, and where short steps are
    dropped: so fewer of them.
    """
    samples = 500 if config is SCALED else 1000 if directions else 3000
    arm, reference, ours = twins(joints, config, directions=directions)
    expected = outcomes(arm, reference, samples)
    np.testing.assert_allclose(ours.run(samples), expected, rtol=0.0, atol=1e-11)
    assert (ours.samples, ours.movements) == (reference.samples, reference.movements)
    assert ours.local_maps == reference.local_maps
    goals = arm.goal_grid()
    np.testing.assert_allclose(ours.inverse(goals), reference.inverse(goals), atol=1e-10)
    np.testing.assert_allclose(ours.inverse(goals[3]), reference.inverse(goals[3]), atol=1e-10)


def test_the_cutoff_learns_as_well() -> None:
    """Near maps only: other paths after a while, errors alike (mean of 10 learners)."""
    errors = np.empty((10, 2))
    for seed, row in enumerate(errors):
        for column, cutoff in enumerate((0.0, 1e-3)):
            arm, _, babbler = twins(5, FAST, directions=False, cutoff=cutoff, seed=seed)
            babbler.run(10_000)
            goals = arm.goal_grid()
            tips = arm.forward(babbler.inverse(goals))
            row[column] = np.linalg.norm(tips - goals, axis=1).mean()
    exact, near = errors.mean(axis=0)
    assert near < 0.02
    assert 0.5 < near / exact < 2.0


def test_stops_at_movements_and_goes_on() -> None:
    """Running in pieces is running at once."""
    _, _, whole = twins(5, FAST, directions=False)
    _, _, pieces = twins(5, FAST, directions=False)
    pieces.run(13)
    pieces.run_movements(9)
    assert (pieces.movements, pieces.samples) == (9, 225)
    whole.run(225)
    np.testing.assert_array_equal(whole.inverse([0.5, 0.1]), pieces.inverse([0.5, 0.1]))


def test_forward_is_that_of_the_arm() -> None:
    """For other lengths as well."""
    arm = PlanarArm(7, length=2.5)
    angles = np.random.default_rng(0).uniform(-math.pi, math.pi, 7)
    babbler = CompiledGoalBabbler(
        GoalBabblerConfig(noise_spread=0.0, home_probability=0.0),
        np.array([[0.0, 0.0], [1.0, 0.0]]),
        angles,
        arm.forward(angles),
        angles,
        angles,
        np.random.default_rng(0),
        planar_arm_forward(2.5),
    )
    tip = babbler.run(1)[0]
    np.testing.assert_allclose(tip, arm.forward(angles), atol=1e-14)


def test_refuses_what_does_not_fit_together() -> None:
    arm = PlanarArm(3)
    home, tip, limits = arm.home(), arm.forward(arm.home()), np.full(3, 3.0)
    rng = np.random.default_rng(0)
    for goals, low in (
        (arm.goal_grid(), limits),
        (arm.goal_grid()[:1], -limits),
        (np.ones((5, 3)), -limits),
        (DirectionTargets(0.1, 3), -limits),
    ):
        with pytest.raises(GoalBabblingError):
            CompiledGoalBabbler(GoalBabblerConfig(), goals, home, tip, low, limits, rng, FORWARD)


@pytest.mark.parametrize(
    "setting",
    [
        {"model": "recursive_maps"},
        {"goal_candidates": 3},
        {"abort_distance": 0.1},
        {"stay_steps": 1},
        {"rest_error": 0.1},
        {"noise_per_error": 0.3},
        {"forward_model": "polynomial"},
    ],
    ids=lambda setting: next(iter(setting)),
)
def test_what_only_the_reference_can_do_is_refused(setting: dict[str, object]) -> None:
    arm = PlanarArm(2)
    limits = np.full(2, np.pi)
    task = (GoalBabblerConfig(**setting), arm.goal_grid(), arm.home(), np.array([0.7, 0.0]))
    with pytest.raises(GoalBabblingError, match="use GoalBabbler"):
        CompiledGoalBabbler(*task, -limits, limits, np.random.default_rng(0), FORWARD)
