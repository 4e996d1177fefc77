"""The last step to a goal, on functions whose every value is known."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.planar_arm import PlanarArm
from bha_goal_babbling.refinement import refined


class Arm(PlanarArm):
    """An arm that is known, as a forward model."""

    def predict(self, action: FloatArray) -> FloatArray:
        return self.forward(action)


class Linear:
    """x = J q, as a forward model."""

    def __init__(self, slope: FloatArray) -> None:
        self.slope = np.array(slope, dtype=float)

    def predict(self, action: FloatArray) -> FloatArray:
        outcome: FloatArray = self.slope @ action
        return outcome

    def jacobian(self, action: FloatArray) -> FloatArray:
        return self.slope


class Unsure(Linear):
    """The same, and sure of it about an action that is known."""

    def __init__(self, slope: FloatArray, known: FloatArray, curvature: FloatArray) -> None:
        super().__init__(slope)
        self.known, self.curvature = known, curvature

    def variance_near(self, action: FloatArray) -> tuple[FloatArray, FloatArray]:
        return self.curvature @ (action - self.known), self.curvature


WIDE = np.full(5, 3.0)
ARM = Arm(5, length=2.0)
"""Two metres long: about the slopes of the trunk in scaled units."""


@pytest.mark.parametrize("seed", range(10))
def test_hits_a_goal_nearby(seed: int) -> None:
    """Five joints for two coordinates: a hundredth of the miss is left, and the way is short."""
    rng = np.random.default_rng(seed)
    start = ARM.home(reach=0.6) + 0.1 * rng.standard_normal(5)
    step = 0.15 * rng.standard_normal(2)
    goal = ARM.forward(start) + step
    answer = refined(start, goal, ARM, -WIDE, WIDE, 10.0)
    assert np.linalg.norm(ARM.forward(answer) - goal) < 0.01 * np.linalg.norm(step)
    shortest = np.linalg.pinv(ARM.jacobian(start)) @ step
    assert np.linalg.norm(answer - start) < 1.5 * np.linalg.norm(shortest)


def test_one_step_is_damped_least_squares() -> None:
    """Three of them on x = J q leave (d^2 / (s^2 + d^2))^3 of what lies along each singular value.

    Nothing happens along actions that move nothing.
    """
    rng = np.random.default_rng(0)
    model, start = Linear(rng.standard_normal((2, 5))), rng.standard_normal(5)
    left, _, right = np.linalg.svd(model.slope, full_matrices=False)
    model.slope = left * [1.0, 0.1] @ right
    missed = 0.02 * rng.standard_normal(2)
    answer = refined(start, model.predict(start) + missed, model, -9 * WIDE, 9 * WIDE, 10.0)
    remaining = left.T @ (missed - model.slope @ (answer - start))
    shares = (0.01 / (np.array([1.0, 0.1]) ** 2 + 0.01)) ** 3
    np.testing.assert_allclose(remaining, shares * (left.T @ missed), atol=1e-14)
    np.testing.assert_allclose(right.T @ right @ (answer - start), answer - start, atol=1e-14)


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 10_000), width=st.floats(0.0, 1.0), far=st.floats(0.0, 3.0))
def test_stays_within_the_ends(seed: int, width: float, far: float) -> None:
    """Wherever it begins and the goal is; it goes by `reach` and what the ends take, no farther."""
    rng = np.random.default_rng(seed)
    start = ARM.home() + far * rng.standard_normal(5)
    low = ARM.home() - width * rng.random(5)
    high = low + width * rng.random(5)
    reach = rng.uniform(0.01, 1.0)
    answer = refined(start, far * rng.standard_normal(2), ARM, low, high, reach)
    assert (low - 1e-12 <= answer).all()
    assert (answer <= high + 1e-12).all()
    begin = np.clip(start, low, high)
    reach += float(np.linalg.norm(begin - start))
    assert np.linalg.norm(answer - begin) <= reach * (1 + 1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_a_cautious_answer_makes_the_expected_miss_least(seed: int) -> None:
    """|x* - J q|^2 + n v(q), v = (q - known)' U (q - known): least squares tells the answer."""
    rng = np.random.default_rng(seed)
    slope, known = rng.standard_normal((2, 5)), 0.2 * rng.standard_normal(5)
    root = np.diag(rng.uniform(0.3, 1.0, 5)) @ np.linalg.qr(rng.standard_normal((5, 5)))[0]
    model = Unsure(slope, known, root.T @ root)
    start, goal = known + 0.2 * rng.standard_normal(5), slope @ known + 0.1
    answer = refined(start, goal, model, -WIDE, WIDE, 10.0, cautious=True)
    rows = np.vstack([slope, np.sqrt(2.0) * root])
    right = np.concatenate([goal, np.sqrt(2.0) * root @ known])
    best = np.linalg.lstsq(rows, right, rcond=None)[0]
    np.testing.assert_allclose(answer, best, atol=1e-3)
    bold = refined(start, goal, model, -WIDE, WIDE, 10.0)
    assert np.linalg.norm(bold - best) > 0.05


def test_a_cautious_answer_stays_within_the_ends() -> None:
    """Also where all that is known lies beyond them, and the goal is far."""
    model = Unsure(np.ones((1, 2)), np.array([2.0, -1.0]), np.eye(2))
    ends = np.array([0.5, 0.5])
    answer = refined(np.zeros(2), np.array([1.0]), model, -ends, ends, 10.0, cautious=True)
    np.testing.assert_allclose(answer, [0.5, -0.25], atol=0.01)


def test_others_make_up_for_an_entry_at_its_end() -> None:
    """Even one after the other; the goal is met all the same, and none of them turns back."""
    model = Linear([[1.0, 0.8, 0.6]])
    low, high = np.full(3, -1.0), np.array([0.05, 0.1, 1.0])
    answer = refined(np.zeros(3), np.array([0.2]), model, low, high, 10.0)
    assert answer[0] == 0.05
    assert answer[1] == pytest.approx(0.1, abs=1e-3)
    assert answer[2] == pytest.approx((0.2 - 0.05 - 0.08) / 0.6, rel=0.02)
    downwards = refined(np.zeros(3), np.array([-0.2]), model, -high, -low, 10.0)
    np.testing.assert_array_equal(downwards, -answer)


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 10_000), outcomes=st.integers(1, 3))
def test_a_step_is_the_best_within_the_ends(seed: int, outcomes: int) -> None:
    """What one iteration costs is what SciPy's bounded least squares costs, or less.

    The second and third leave it there: they are told that nothing is missed any more.
    """
    rng = np.random.default_rng(seed)
    slope = rng.standard_normal((outcomes, 9))
    low, high = -rng.exponential(0.1, 9), rng.exponential(0.1, 9)
    missed = 0.2 * rng.standard_normal(outcomes) / np.sqrt(outcomes)

    class Once(Linear):
        """Misses nothing any more once it was asked."""

        asked = False

        def predict(self, action: FloatArray) -> FloatArray:
            self.asked, asked = True, self.asked
            return missed if asked else np.zeros(outcomes)

    def cost(step: FloatArray) -> float:
        left = missed * min(1.0, 0.2 / np.linalg.norm(missed)) - slope @ step
        return float(left @ left + 0.01 * step @ step)

    step = refined(np.zeros(9), missed, Once(slope), low, high, 1e3)
    shortened = missed * min(1.0, 0.2 / np.linalg.norm(missed))
    rows, right = np.vstack([slope, 0.1 * np.eye(9)]), np.append(shortened, np.zeros(9))
    assert cost(step) <= cost(lsq_linear(rows, right, (low, high), tol=1e-14).x) + 1e-9


def test_answers_do_not_jump() -> None:
    """A goal on its way out of reach moves the answer as little as itself.

    An entry that came to its end early and was not let go again would make answers jump.
    """
    rng = np.random.default_rng(0)
    for _ in range(20):
        model = Linear(rng.standard_normal((3, 9)))
        low, high = -rng.exponential(0.05, 9), rng.exponential(0.05, 9)
        way = np.linspace(0.0, 0.5, 2000)[:, None] * rng.standard_normal(3)
        answers = [refined(np.zeros(9), goal, model, low, high, 10.0) for goal in way]
        steps = np.linalg.norm(np.diff(answers, axis=0), axis=1)
        assert steps.max() < 20.0 * np.linalg.norm(way[1])


def test_gives_up_what_no_entry_can_bring() -> None:
    """All ends are reached, nothing more."""
    model = Linear([[1.0, 0.8, 0.6]])
    high = np.array([0.02, 0.01, 0.0])
    answer = refined(np.zeros(3), np.array([0.3]), model, -high, high, 10.0)
    np.testing.assert_array_equal(answer, high)


def test_begins_within_the_ends() -> None:
    """An answer outside of its range is moved in first, and the others make up for that."""
    model = Linear([[1.0, 1.0]])
    low, high = np.full(2, -1.0), np.array([0.3, 1.0])
    answer = refined(np.array([0.4, 0.0]), np.array([0.4]), model, low, high, 10.0)
    np.testing.assert_allclose(answer, [0.3, 0.1], atol=1e-4)


@pytest.mark.parametrize("reach", [0.05, 0.1])
def test_goes_no_farther_than_its_reach(reach: float) -> None:
    """In the direction in which it would have gone on."""
    start = ARM.home()
    goal = ARM.forward(start) + np.array([-0.3, 0.3])
    free = refined(start, goal, ARM, -WIDE, WIDE, 10.0) - start
    short = refined(start, goal, ARM, -WIDE, WIDE, reach) - start
    assert np.linalg.norm(free) > 0.1
    assert np.linalg.norm(short) == pytest.approx(reach)
    np.testing.assert_allclose(short, free * reach / np.linalg.norm(free), atol=1e-12)


def test_trusts_the_slope_for_small_steps_only() -> None:
    """A goal out of sight moves it by ten steps of 0.2, less the damping."""
    far = np.full(2, 1e3)
    answer = refined(np.zeros(2), np.array([30.0, 40.0]), Linear(np.eye(2)), -far, far, 1e3)
    np.testing.assert_allclose(answer, 10 * 0.2 / 1.01 * np.array([0.6, 0.8]), rtol=1e-12)


def test_others_make_up_for_all_that_an_end_has_taken() -> None:
    """A valve is stuck: a length is 1.5 from where it is wanted, and another one has to go there.

    That is more than `reach`, and more than what three steps of 0.2 bring.
    """
    model = Linear(np.ones((1, 2)))
    low, high = np.array([0.0, -9.0]), np.array([0.0, 9.0])
    answer = refined(np.array([1.5, 0.0]), np.array([1.5]), model, low, high, 0.4)
    np.testing.assert_allclose(answer, [0.0, 1.5], atol=1e-4)


def test_a_model_that_knows_nothing_moves_nothing() -> None:
    start = np.array([0.3, -5.0])
    low, high = np.full(2, -1.0), np.full(2, 1.0)
    answer = refined(start, np.array([1.0, 1.0]), Linear(np.zeros((2, 2))), low, high, 10.0)
    np.testing.assert_array_equal(answer, [0.3, -1.0])


def test_leaves_its_arguments_alone() -> None:
    start, goal = np.array([0.3, -5.0]), np.array([1.0, 1.0])
    low, high = np.full(2, -0.1), np.full(2, 0.1)
    before = [each.copy() for each in (start, goal, low, high)]
    refined(start, goal, Linear(np.eye(2)), low, high, 0.1)
    for each, copy in zip((start, goal, low, high), before, strict=True):
        np.testing.assert_array_equal(each, copy)
