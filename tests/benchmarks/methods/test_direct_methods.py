"""Direct fit, differential inverse, nearest neighbour: answers where they are known."""

import numpy as np

from benchmarks.arm.reaching import ReachingTask
from benchmarks.methods.differential_inverse import DifferentialInverse, DifferentialMaps
from benchmarks.methods.direct_fit import DirectFit
from benchmarks.methods.nearest_neighbour import NearestNeighbour
from benchmarks.methods.world import World


def test_direct_fit_answers_with_the_average_of_non_convex_solutions() -> None:
    """For x = q^2 both roots are seen equally often; the fit answers 0, whatever x is."""
    goals = np.linspace(0.2, 0.8, 7)[:, np.newaxis]
    world = World(np.square, np.zeros(1), -np.ones(1), np.ones(1), goals)
    method = DirectFit(world, np.random.default_rng(0), spread=1.0)
    method.run(4000)
    assert np.abs(method.inverse(goals)).max() < 0.1
    assert world.error(method.inverse(goals)) > 0.4


def test_direct_fit_is_right_where_solutions_are_convex() -> None:
    """For x = q it finds q."""
    goals = np.linspace(-0.8, 0.8, 7)[:, np.newaxis]
    world = World(np.copy, np.zeros(1), -np.ones(1), np.ones(1), goals)
    method = DirectFit(world, np.random.default_rng(0), spread=1.0, ridge=1e-6)
    method.run(200)
    np.testing.assert_allclose(method.inverse(goals), goals, atol=1e-4)


def test_differential_maps_learn_the_pseudo_inverse() -> None:
    """Steps without a preferred direction through a constant Jacobian give J^+."""
    rng = np.random.default_rng(1)
    jacobian = rng.standard_normal((2, 4))
    maps = DifferentialMaps(np.zeros(2), np.zeros(4), 1.0, 1.0, 1e-9)
    for step in 0.01 * rng.standard_normal((20000, 4)):
        maps.learn(np.zeros(2), np.zeros(4), jacobian @ step, step)
    assert maps.count == 1
    learned = maps.inverses(np.zeros((1, 2)), np.zeros((1, 4)))[0]
    np.testing.assert_allclose(learned, np.linalg.pinv(jacobian), atol=0.02)


def test_differential_maps_keep_postures_apart() -> None:
    """Where the Jacobian has another sign at another posture, each map has its own."""
    rng = np.random.default_rng(2)
    maps = DifferentialMaps(np.zeros(1), np.full(1, -2.0), 1.0, 0.5, 1e-9)
    for place in (-2.0, 2.0):
        for step in 0.01 * rng.standard_normal((100, 1)):
            maps.learn(np.zeros(1), np.full(1, place), np.sign(place) * step, step)
    assert maps.count == 2
    learned = maps.inverses(np.zeros((2, 1)), np.array([[-2.0], [2.0]]))
    np.testing.assert_allclose(learned[:, 0, 0], [-1.0, 1.0], atol=1e-3)


def test_differential_inverse_integrates_to_the_goals_of_a_linear_world() -> None:
    rng = np.random.default_rng(3)
    forward = np.linalg.qr(rng.standard_normal((4, 2)))[0].T
    goals = np.array([[0.3, 0.2], [-0.3, 0.1], [0.1, -0.4]])
    limits = np.full(4, 5.0)
    world = World(lambda q: forward @ q, np.zeros(4), -limits, limits, goals)
    method = DifferentialInverse(world, rng)
    method.run(3000)
    assert world.error(method.inverse(goals)) < 0.02


def test_nearest_neighbour_answers_with_executed_actions() -> None:
    """Each answer was executed, and no other that was came closer."""
    task = ReachingTask(5)
    world = World.of_task(task)
    executed = [world.home_action]
    forward = world._forward
    world._forward = lambda q: (executed.append(q), forward(q))[1]
    method = NearestNeighbour(world, np.random.default_rng(4))
    method.run(350)  # Some are in the tree, some still in the buffer.
    answers = method.inverse(world.goals)
    actions = np.array(executed)
    gaps = np.linalg.norm(task.arm.forward(actions) - world.goals[:, np.newaxis], axis=2)
    np.testing.assert_array_equal(answers, actions[gaps.argmin(axis=1)])
