"""Feedback-error learning, distal teacher, reward-weighted regression: what each step does."""

import numpy as np
import pytest
from scipy.optimize import approx_fprime

from benchmarks.methods.distal_teacher import DistalTeacher, distal_step
from benchmarks.methods.feedback_error import FeedbackErrorLearning, inverse_jacobian
from benchmarks.methods.forward_model import ForwardModel, ForwardModelSettings
from benchmarks.methods.goal_features import GoalModel
from benchmarks.methods.reward_weighted import RewardWeightedRegression, weighted_change
from benchmarks.methods.world import World
from bha_goal_babbling.planar_arm import PlanarArm

GOALS = np.array([[x, y] for x in (-0.5, 0.0, 0.5) for y in (-0.5, 0.0, 0.5)])


def linear_world(scale: float = 1.0) -> tuple[np.ndarray, World]:
    """Return F and the world x = F q with 4 actions and 2 outcomes."""
    forward = scale * np.linalg.qr(np.random.default_rng(0).standard_normal((4, 2)))[0].T
    limits = np.full(4, 5.0)
    return forward, World(lambda q: forward @ q, np.zeros(4), -limits, limits, GOALS)


def test_goal_model_goes_the_whole_way_at_rate_one() -> None:
    model = GoalModel(GOALS, 0.5, np.zeros(3))
    model.change(GOALS[2], np.array([1.0, -2.0, 3.0]), 1.0)
    np.testing.assert_allclose(model(GOALS[2:3])[0], [1.0, -2.0, 3.0])


def test_distal_step_is_the_numerical_gradient() -> None:
    """Through a learned forward model, with respect to the action and to a model's parameters."""
    rng = np.random.default_rng(1)
    arm = PlanarArm(3)
    forward = ForwardModel(arm.home(), arm.forward(arm.home()), ForwardModelSettings(waves=60), rng)
    for action in arm.home() + rng.uniform(-0.5, 0.5, (300, 3)):
        forward.learn(action, arm.forward(action))
    goal, action = np.array([0.5, 0.2]), arm.home() + 0.1

    def cost(q: np.ndarray) -> float:
        return 0.5 * float(np.square(goal - forward.predict(q[np.newaxis])[0]).sum())

    error = goal - forward.predict(action[np.newaxis])[0]
    step = distal_step(forward.jacobian(action[np.newaxis])[0], error)
    np.testing.assert_allclose(step, -approx_fprime(action, cost, 1e-6), atol=1e-4)

    model = GoalModel(arm.goal_grid(), 0.5, arm.home())

    def cost_of_parameters(flat: np.ndarray) -> float:
        q = arm.home() + model.features(goal[np.newaxis])[0] @ flat.reshape(-1, 3)
        return cost(q)

    error = goal - forward.predict(arm.home()[np.newaxis])[0]
    step = distal_step(forward.jacobian(arm.home()[np.newaxis])[0], error)
    model.change(goal, step, 1.0)
    gradient = approx_fprime(np.zeros(model.parameters.size), cost_of_parameters, 1e-6)
    features = model.features(goal[np.newaxis])[0]
    np.testing.assert_allclose(
        model.parameters.ravel() * (features @ features), -gradient, atol=1e-4
    )


@pytest.mark.parametrize("scale", [0.3, 3.0])
def test_distal_teacher_inverts_a_linear_world_of_any_scale(scale: float) -> None:
    _, world = linear_world(scale)
    method = DistalTeacher(
        world,
        np.random.default_rng(2),
        babbling=50,
        forward_model=ForwardModelSettings(length=5.0, waves=20),
    )
    before = world.error(method.inverse(GOALS))
    method.run(1500)
    assert world.error(method.inverse(GOALS)) < 0.05 * before


def test_feedback_error_learning_ends_where_feedback_is_silent() -> None:
    """In a linear world that is the pseudo-inverse: feedback never moves in the null space."""
    forward, world = linear_world()
    feedback = inverse_jacobian(lambda _: forward, damping=0.0)
    method = FeedbackErrorLearning(world, np.random.default_rng(3), feedback)
    method.run(3000)
    np.testing.assert_allclose(method.inverse(GOALS), GOALS @ forward, atol=0.01)


def test_feedback_error_learning_learns_nothing_without_feedback() -> None:
    """Feedback alone is the teacher."""
    _, world = linear_world()
    method = FeedbackErrorLearning(
        world, np.random.default_rng(3), lambda action, error: np.zeros_like(action)
    )
    method.run(200)
    np.testing.assert_array_equal(method.inverse(GOALS), np.zeros((9, 4)))


def test_reward_weighted_fit_is_weighted_least_squares() -> None:
    """Against least squares on rows scaled by the roots of the weights."""
    rng = np.random.default_rng(4)
    features, residuals = rng.standard_normal((30, 5)), rng.standard_normal((30, 3))
    weights = rng.uniform(0.0, 1.0, 30)
    root = np.sqrt(weights)[:, np.newaxis]
    expected = np.linalg.lstsq(root * features, root * residuals)[0]
    np.testing.assert_allclose(
        weighted_change(features, residuals, weights, 1e-12), expected, atol=1e-9
    )


def test_a_trial_of_no_weight_changes_nothing() -> None:
    """One good trial among bad ones is what the policy moves to."""
    features = np.ones((3, 1))
    residuals = np.array([[1.0, 2.0], [50.0, 0.0], [0.0, 50.0]])
    change = weighted_change(features, residuals, np.array([1.0, 0.0, 0.0]), 1e-9)
    np.testing.assert_allclose(change, [[1.0, 2.0]], rtol=1e-6)


def test_reward_weighted_regression_improves_on_a_linear_world() -> None:
    _, world = linear_world()
    method = RewardWeightedRegression(
        world, np.random.default_rng(5), exploration=0.2, distance=1.0
    )
    before = world.error(method.inverse(GOALS))
    method.run(4000)
    assert world.error(method.inverse(GOALS)) < 0.2 * before
