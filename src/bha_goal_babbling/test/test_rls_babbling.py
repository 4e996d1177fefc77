"""RLS goal babbling as a whole: how fast, with limits, with noise, in three dimensions."""

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm


def arm_babbler(
    joints: int, seed: int, config: GoalBabblerConfig, limit: float = np.pi
) -> tuple[PlanarArm, GoalBabbler]:
    arm, limits = PlanarArm(joints), np.full(joints, limit)
    home = arm.home()
    rng = np.random.default_rng(seed)
    goals = arm.goal_grid()
    return arm, GoalBabbler(config, goals, home, arm.forward(home), -limits, limits, rng)


def errors(arm: PlanarArm, babbler: GoalBabbler) -> FloatArray:
    """Return the distances of noiseless reaches to the goals of the grid [m], shape (G,)."""
    goals = arm.goal_grid()
    distances: FloatArray = np.linalg.norm(arm.forward(babbler.inverse(goals)) - goals, axis=1)
    return distances


def samples_to_a_tenth(joints: int, seed: int, most: int) -> int:
    arm, babbler = arm_babbler(joints, seed, GoalBabblerConfig.rls())
    first = errors(arm, babbler).mean()
    for sample in range(1, most + 1):
        action = babbler.ask()
        babbler.tell(action, arm.forward(action))
        if errors(arm, babbler).mean() <= 0.1 * first:
            return sample
    return most + 1


@pytest.mark.parametrize("joints", [2, 20])
def test_a_hundred_samples_bring_the_error_to_a_tenth(joints: int) -> None:
    """The median is about 90; the gradient method needs several hundred."""
    needed = [samples_to_a_tenth(joints, seed, 600) for seed in range(7)]
    assert np.median(needed) <= 150, needed


def test_goes_on_getting_better() -> None:
    arm, babbler = arm_babbler(5, 0, GoalBabblerConfig.rls())
    medians = []
    for _ in range(3):
        for _ in range(1500):
            action = babbler.ask()
            babbler.tell(action, arm.forward(action))
        medians.append(float(np.median(errors(arm, babbler))))
    assert medians[-1] < medians[0]
    assert medians[-1] < 2e-3


def test_limits_are_kept_and_goals_within_them_reached() -> None:
    arm, babbler = arm_babbler(6, 0, GoalBabblerConfig.rls(), limit=1.3)
    for _ in range(3000):
        action = babbler.ask()
        assert np.abs(action).max() <= 1.3
        babbler.tell(action, arm.forward(action))
    assert np.abs(babbler.inverse(arm.goal_grid())).max() <= 1.3
    assert np.median(errors(arm, babbler)) < 0.01


def test_a_lower_gain_averages_sensor_noise() -> None:
    """With 5 mm of noise on outcomes the recipe for it ends below the one for clean outcomes."""

    def error(seed: int, config: GoalBabblerConfig) -> float:
        arm, babbler = arm_babbler(5, seed, config)
        rng = np.random.default_rng(100 + seed)
        for _ in range(3000):
            action = babbler.ask()
            babbler.tell(action, arm.forward(action) + 0.005 * rng.standard_normal(2))
        return float(np.median(errors(arm, babbler)))

    clean = [error(seed, GoalBabblerConfig.rls()) for seed in range(2)]
    careful = [error(seed, GoalBabblerConfig.rls(process_noise=0.005)) for seed in range(2)]
    assert np.mean(careful) < np.mean(clean) < 0.01


def test_three_dimensions() -> None:
    """Six actions that move a point in space, in a bent way; goals on the corners of a box."""
    mixing = np.random.default_rng(0).standard_normal((3, 6)) / 3.0
    forward = lambda action: np.tanh(mixing @ action)  # noqa: E731
    goals = 0.3 * np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3), axis=-1).reshape(-1, 3)
    limits = np.full(6, 4.0)
    babbler = GoalBabbler(
        GoalBabblerConfig.rls(map_distance=0.2, final_map_distance=0.1, noise_spread=0.1),
        goals,
        np.zeros(6),
        np.zeros(3),
        -limits,
        limits,
        np.random.default_rng(1),
    )
    for _ in range(2000):
        action = babbler.ask()
        babbler.tell(action, forward(action))
    reached = np.array([forward(action) for action in babbler.inverse(goals)])
    assert np.linalg.norm(reached - goals, axis=1).mean() < 0.01
