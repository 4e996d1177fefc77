"""The whole learner: its protocol, what it learns from, and how fast it learns."""

import math

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.direction_sampling import DirectionTargets
from bha_goal_babbling.errors import (
    GoalBabblingError,
    InvalidArrayError,
    InvalidConfigError,
    WrongOrderError,
)
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm


def arm_babbler(
    joints: int = 5,
    seed: int = 0,
    config: GoalBabblerConfig | None = None,
    limit: float = math.pi,
) -> tuple[PlanarArm, GoalBabbler]:
    """Return an arm, and a learner on it."""
    arm = PlanarArm(joints)
    home = arm.home()
    limits = np.full(joints, limit)
    babbler = GoalBabbler(
        config or GoalBabblerConfig(),
        arm.goal_grid(),
        home,
        arm.forward(home),
        -limits,
        limits,
        np.random.default_rng(seed),
    )
    return arm, babbler


def step(arm: PlanarArm, babbler: GoalBabbler) -> FloatArray:
    """Execute one action and tell what came of it."""
    action = babbler.ask()
    babbler.tell(action, arm.forward(action))
    return action


def error(arm: PlanarArm, babbler: GoalBabbler) -> float:
    """Return the mean distance of noiseless reaches to the goals of the grid [m]."""
    goals = arm.goal_grid()
    return float(np.linalg.norm(arm.forward(babbler.inverse(goals)) - goals, axis=1).mean())


def movements_to_a_tenth(joints: int, seed: int, most: int) -> int:
    """Return the movements after which the error is a tenth of the first; `most` + 1 if never."""
    arm, babbler = arm_babbler(joints, seed)
    first = error(arm, babbler)
    while babbler.movements <= most:
        before = babbler.movements
        step(arm, babbler)
        if babbler.movements > before and error(arm, babbler) < 0.1 * first:
            break
    return babbler.movements


def test_starts_at_home() -> None:
    """Before anything is learned every goal is answered with the home action."""
    arm, babbler = arm_babbler()
    np.testing.assert_array_equal(babbler.inverse(arm.goal_grid()), np.tile(arm.home(), (77, 1)))
    assert (babbler.movements, babbler.samples, babbler.local_maps) == (0, 0, 1)
    assert math.isnan(babbler.recent_error)


def test_asks_the_same_until_it_is_told() -> None:
    """Asking changes nothing after the first time."""
    arm, babbler = arm_babbler()
    first = babbler.ask()
    first_copy = first.copy()
    first[:] = 0.0
    np.testing.assert_array_equal(babbler.ask(), first_copy)
    babbler.tell(first_copy, arm.forward(first_copy))
    assert not np.array_equal(babbler.ask(), first_copy)


def test_tell_without_ask_is_an_error() -> None:
    """Also a second time for one question."""
    arm, babbler = arm_babbler()
    with pytest.raises(WrongOrderError, match="ask"):
        babbler.tell(np.zeros(5), np.zeros(2))
    step(arm, babbler)
    with pytest.raises(WrongOrderError, match="ask"):
        babbler.tell(np.zeros(5), np.zeros(2))


@pytest.mark.parametrize(
    ("action", "outcome"),
    [
        (np.full(5, np.nan), np.zeros(2)),
        (np.zeros(5), np.array([0.0, np.inf])),
        (np.full(5, 1e200), np.zeros(2)),
        (np.zeros(4), np.zeros(2)),
        (np.zeros(5), np.zeros(3)),
        (np.zeros((1, 5)), np.zeros(2)),
    ],
)
def test_bad_samples_change_nothing(action: FloatArray, outcome: FloatArray) -> None:
    """The refused learner goes on exactly as one that never heard of the bad sample."""
    arm, babbler = arm_babbler()
    _, twin = arm_babbler()
    for _ in range(60):
        step(arm, babbler)
        step(arm, twin)
    babbler.ask()
    with pytest.raises(GoalBabblingError):
        babbler.tell(action, outcome)
    for _ in range(60):
        np.testing.assert_array_equal(step(arm, babbler), step(arm, twin))


def test_actions_keep_the_limits() -> None:
    """Commands and answers are clipped, and the clipped ones are what is executed."""
    arm, babbler = arm_babbler(limit=1.5)
    actions = np.array([step(arm, babbler) for _ in range(2000)])
    assert np.abs(actions).max() == 1.5
    assert np.abs(babbler.inverse(arm.goal_grid())).max() <= 1.5


def test_learns_what_was_executed_not_what_was_wished() -> None:
    """Joints run 0.05 rad off: with the measured angles goals are met, with the commands missed."""
    arm, measuring = arm_babbler(seed=1)
    _, wishing = arm_babbler(seed=1)
    for _ in range(3000):
        measured = measuring.ask() + 0.05
        measuring.tell(measured, arm.forward(measured))
        wished = wishing.ask()
        wishing.tell(wished, arm.forward(wished + 0.05))
    assert error(arm, measuring) < 0.03
    assert error(arm, wishing) > 0.06


def test_untrusted_samples_are_not_learned() -> None:
    """With learn=False the path goes on and the model stays."""
    arm, babbler = arm_babbler()
    for _ in range(100):
        action = babbler.ask()
        babbler.tell(action, arm.forward(action), learn=False)
    assert (babbler.samples, babbler.movements, babbler.local_maps) == (100, 4, 1)
    assert math.isnan(babbler.recent_error)
    np.testing.assert_array_equal(babbler.inverse([0.5, 0.5]), arm.home())


def test_a_sample_that_did_not_move_is_not_learned() -> None:
    """A stuck robot teaches nothing."""
    arm, babbler = arm_babbler()
    home = arm.home()
    for _ in range(30):
        babbler.ask()
        babbler.tell(home, arm.forward(home))
    np.testing.assert_array_equal(babbler.inverse([0.5, 0.5]), home)


def test_rests_without_noise() -> None:
    """Where a goal that was met stays the target, the inverse model's own answer is executed."""
    config = GoalBabblerConfig.rls(rest_steps=4, rest_error=0.05, home_probability=0.0)
    arm, babbler = arm_babbler(config=config)
    target, rests = babbler.target, 0
    for _ in range(1000):
        action = babbler.ask()
        own = babbler.inverse(babbler.target)
        resting = np.array_equal(babbler.target, target)
        assert np.array_equal(action, own) == resting
        rests += resting
        target = babbler.target
        babbler.tell(action, arm.forward(action))
    assert rests > 100


def test_returns_home() -> None:
    """Movements home end at the home action, and g keeps the way there."""
    arm, babbler = arm_babbler()
    arrivals = []
    while babbler.movements < 100:
        before, going_home = babbler.movements, False
        action = babbler.ask()
        going_home = babbler.going_home
        babbler.tell(action, arm.forward(action))
        if babbler.movements > before and going_home:
            arrivals.append(action)
    assert len(arrivals) > 3
    np.testing.assert_array_equal(arrivals, np.tile(arm.home(), (len(arrivals), 1)))
    at_home = babbler.inverse(arm.forward(arm.home()))
    assert np.abs(at_home - arm.home()).max() < 0.2


def test_recent_error_follows_the_ends_of_movements() -> None:
    """It is the running mean of the distance to the goal at the last step."""
    arm, babbler = arm_babbler(config=GoalBabblerConfig(home_probability=0.0, error_window=3))
    misses: list[float] = []
    mean = math.nan
    while len(misses) < 8:
        action = babbler.ask()
        target = babbler.target
        babbler.tell(action, arm.forward(action))
        if babbler.movements > len(misses):
            misses.append(float(np.linalg.norm(arm.forward(action) - target)))
            count = min(len(misses), 3)
            mean = misses[0] if count == 1 else mean + (misses[-1] - mean) / count
            assert babbler.recent_error == pytest.approx(mean)


def test_linear_robot_is_inverted() -> None:
    """On x = F q goals are reached to 1 %, with actions near the shortest there are."""
    rng = np.random.default_rng(0)
    forward = np.linalg.qr(rng.standard_normal((6, 2)))[0].T
    goals = np.stack(np.meshgrid(*[np.linspace(-1, 1, 5)] * 2), axis=-1).reshape(-1, 2)
    config = GoalBabblerConfig(
        map_distance=1.5, learning_rate=0.1, noise_spread=0.2, noise_step=0.6, path_steps=5
    )
    limits = np.full(6, 10.0)
    babbler = GoalBabbler(config, goals, np.zeros(6), np.zeros(2), -limits, limits, rng)
    for _ in range(4000):
        action = babbler.ask()
        babbler.tell(action, forward @ action)
    actions = babbler.inverse(goals)
    assert np.linalg.norm(actions @ forward.T - goals, axis=1).mean() < 0.01
    shortest = goals @ np.linalg.pinv(forward).T
    assert np.linalg.norm(actions - shortest) < 0.4 * np.linalg.norm(shortest)


def test_ten_joints_need_about_twenty_movements() -> None:
    """The error falls to a tenth within the usual number of movements (median about 23)."""
    needed = [movements_to_a_tenth(10, seed, 100) for seed in range(5)]
    assert 10 <= np.median(needed) <= 40, needed
    assert max(needed) <= 100, needed


def test_learning_is_the_same_for_the_same_seed() -> None:
    """All randomness comes from the generator that is passed in."""
    arm, first = arm_babbler(seed=3)
    _, second = arm_babbler(seed=3)
    _, other = arm_babbler(seed=4)
    for _ in range(300):
        step(arm, first)
        step(arm, second)
        step(arm, other)
    np.testing.assert_array_equal(first.ask(), second.ask())
    assert not np.array_equal(first.ask(), other.ask())


def test_directions_explore_the_workspace() -> None:
    """Without any goals the outcomes spread over most of the disc that the arm can reach."""
    arm = PlanarArm(5)
    home, limits = arm.home(), np.full(5, math.pi)
    babbler = GoalBabbler(
        GoalBabblerConfig(),
        DirectionTargets(0.02, 2),
        home,
        arm.forward(home),
        -limits,
        limits,
        np.random.default_rng(0),
    )
    cells = {tuple(np.floor(arm.forward(step(arm, babbler)) / 0.2)) for _ in range(5000)}
    assert len(cells) * 0.2**2 > 0.6 * math.pi


def test_arrays_are_copied() -> None:
    """Arrays that the caller reuses do not change the learner."""
    arm, babbler = arm_babbler()
    _, twin = arm_babbler()
    buffer, tip = np.empty(5), np.empty(2)
    for _ in range(60):
        buffer[:] = babbler.ask()
        tip[:] = arm.forward(buffer)
        babbler.tell(buffer, tip)
        step(arm, twin)
    buffer[:], tip[:] = 0.0, 0.0
    np.testing.assert_array_equal(babbler.ask(), twin.ask())


def test_refuses_what_does_not_fit_together() -> None:
    """Home outside of the limits, goals of another dimension, NaN."""
    arm = PlanarArm(3)
    home, tip, limits = arm.home(), arm.forward(arm.home()), np.full(3, 3.0)
    rng, config, goals = np.random.default_rng(0), GoalBabblerConfig(), arm.goal_grid()
    with pytest.raises(InvalidConfigError, match="home_action"):
        GoalBabbler(config, goals, home, tip, -0.1 * limits, 0.1 * limits, rng)
    with pytest.raises(InvalidArrayError, match="goals have 3"):
        GoalBabbler(config, np.ones((5, 3)), home, tip, -limits, limits, rng)
    with pytest.raises(InvalidArrayError, match="home_outcome"):
        GoalBabbler(config, goals, home, np.full(2, np.nan), -limits, limits, rng)
    with pytest.raises(InvalidArrayError, match="action_low"):
        GoalBabbler(config, goals, home, tip, np.zeros(4), limits, rng)
    with pytest.raises(InvalidArrayError, match="goal"):
        arm_babbler()[1].inverse(np.zeros(3))
