"""Forward models and what is done with them: regression, inverse Jacobian, null space, babbling."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from benchmarks.arm.reaching import ReachingTask
from benchmarks.methods.forward_model import ForwardModel, ForwardModelSettings
from benchmarks.methods.inverse_jacobian import follow_lines, resolved_step
from benchmarks.methods.motor_babbling import MotorBabbling
from benchmarks.methods.null_space_home import NullSpaceHome
from benchmarks.methods.random_features import RandomFeatures
from benchmarks.methods.world import World
from bha_goal_babbling.planar_arm import PlanarArm


def linear_world(rng: np.random.Generator) -> tuple[np.ndarray, World]:
    """Return F and the world x = F q with 5 actions and 2 outcomes."""
    forward = np.linalg.qr(rng.standard_normal((5, 2)))[0].T
    goals = np.array([[x, y] for x in (-0.5, 0.0, 0.5) for y in (-0.5, 0.0, 0.5)])
    limits = np.full(5, 4.0)
    return forward, World(lambda q: forward @ q, np.zeros(5), -limits, limits, goals)


def test_slopes_of_features_are_the_numerical_ones() -> None:
    rng = np.random.default_rng(0)
    features = RandomFeatures(rng.standard_normal(4), 0.8, 30, rng)
    parameters = rng.standard_normal((features.count, 2))
    point = rng.standard_normal(4)
    numerical = approx_fprime(point, lambda z: (features(z[np.newaxis]) @ parameters)[0], 1e-6)
    analytic = features.slopes(point[np.newaxis], parameters)[0]
    np.testing.assert_allclose(analytic, numerical, atol=1e-4)


@pytest.mark.parametrize("count", [15, 60])
def test_forward_model_is_ridge_regression_on_all_examples(count: int) -> None:
    """With fewer examples than features (24) and with more; the reference is least squares."""
    rng = np.random.default_rng(1)
    home = np.zeros(3)
    actions = rng.standard_normal((count, 3))
    outcomes = np.stack([np.sin(actions[:, 0]), actions[:, 1] * actions[:, 2]], axis=1)
    model = ForwardModel(
        home, np.zeros(2), ForwardModelSettings(1.0, 20, 0.1), np.random.default_rng(7)
    )
    for part in np.array_split(np.arange(count), 5):
        for index in part:
            model.learn(actions[index], outcomes[index])
        model.predict(actions[:1])  # A fit each part.
    features = RandomFeatures(home, np.sqrt(3.0), 20, np.random.default_rng(7))
    tall = np.vstack([features(actions), 0.1 * np.eye(features.count)])
    padded = np.vstack([outcomes, np.zeros((features.count, 2))])
    parameters = np.linalg.lstsq(tall, padded)[0]
    np.testing.assert_allclose(model.predict(actions), features(actions) @ parameters, atol=1e-9)


def test_resolved_step_is_the_pseudo_inverse_plus_the_null_space_pull() -> None:
    rng = np.random.default_rng(2)
    jacobian = rng.standard_normal((2, 6))
    outcome_step, pull = rng.standard_normal(2), rng.standard_normal(6)
    inverse = np.linalg.pinv(jacobian)
    expected = inverse @ outcome_step + (np.eye(6) - inverse @ jacobian) @ pull
    step = resolved_step(
        jacobian[np.newaxis], outcome_step[np.newaxis], pull[np.newaxis], damping=0.0
    )[0]
    np.testing.assert_allclose(step, expected, atol=1e-12)
    np.testing.assert_allclose(jacobian @ step, outcome_step, atol=1e-12)


def test_lines_on_the_true_model_end_at_the_goals() -> None:
    """With the arm's own kinematics the search misses by less than a millimetre."""
    arm = PlanarArm(6)
    goals = arm.goal_grid((0.3, 0.7), (-0.4, 0.4))
    actions = follow_lines(
        arm.forward,
        lambda q: np.array([arm.jacobian(row) for row in q]),
        lambda q: q,
        arm.home(),
        goals,
    )
    assert np.linalg.norm(arm.forward(actions) - goals, axis=1).max() < 1e-3


def test_a_pull_home_brings_the_null_space_back() -> None:
    """On x = F q the search ends at the pseudo-inverse plus home's part of the null space."""
    forward, world = linear_world(np.random.default_rng(3))
    home = np.array([0.5, -0.4, 0.3, 0.2, -0.1])
    null = np.eye(5) - forward.T @ forward
    actions = follow_lines(
        lambda q: q @ forward.T,
        lambda q: np.tile(forward, (len(q), 1, 1)),
        lambda q: q,
        home,
        world.goals,
        steps=40,
        home_pull=0.5,
        damping=0.0,
    )
    np.testing.assert_allclose(actions, world.goals @ forward + null @ home, atol=1e-9)


@pytest.mark.parametrize("method", [MotorBabbling, NullSpaceHome])
def test_methods_learn_the_pseudo_inverse_of_a_linear_world(
    method: type[MotorBabbling] | type[NullSpaceHome],
) -> None:
    forward, world = linear_world(np.random.default_rng(4))
    learner = method(
        world, np.random.default_rng(0), forward_model=ForwardModelSettings(length=3.0, waves=20)
    )
    learner.run(400)
    assert world.samples == 400
    np.testing.assert_allclose(learner.inverse(world.goals), world.goals @ forward, atol=0.02)


@pytest.mark.parametrize("method", [MotorBabbling, NullSpaceHome])
def test_methods_know_only_home_at_first(
    method: type[MotorBabbling] | type[NullSpaceHome],
) -> None:
    world = World.of_task(ReachingTask(3))
    actions = method(world, np.random.default_rng(0)).inverse(world.goals)
    np.testing.assert_array_equal(actions, np.tile(world.home_action, (len(world.goals), 1)))


def test_exploration_stays_near_home_only_with_the_pull() -> None:
    """Without the pull the redundant joints drift."""

    def drift(pull: float) -> float:
        world = World.of_task(ReachingTask(10))
        executed = []
        forward = world._forward
        world._forward = lambda q: (executed.append(q), forward(q))[1]
        learner = NullSpaceHome(
            world,
            np.random.default_rng(0),
            home_pull=pull,
            forward_model=ForwardModelSettings(waves=50),
            exploration=0.03,
        )
        learner.run(600)
        return float(np.abs(np.array(executed)[-200:] - world.home_action).mean())

    assert drift(0.0) > 1.5 * drift(0.1)
