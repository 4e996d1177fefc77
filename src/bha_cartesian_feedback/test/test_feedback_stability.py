"""Whatever the settings and the trunk: feedback neither swings for ever nor runs away."""

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bha_cartesian_feedback.goal_integrator import FeedbackSettings, GoalIntegrator

Array = NDArray[np.float64]

PERIOD = 0.1
SECONDS = 150.0


def drive(
    feedback: GoalIntegrator, slope: Array, lag: float, dead: float, noise: float, seed: int
) -> tuple[Array, Array, float]:
    """Let a late, imperfect tip follow the target; errors and targets at the end, first error."""
    rng = np.random.default_rng(seed)
    offset = np.array([0.02, -0.015, 0.02])
    share = 1.0 - np.exp(-PERIOD / lag)
    late = [feedback.goal] * (1 + round(dead / PERIOD))
    tip = feedback.goal + offset
    errors, targets = [], []
    for tick in range(1, round(SECONDS / PERIOD) + 1):
        seen = tip + noise * rng.standard_normal(3)
        late.append(feedback.update(tick * PERIOD, seen))
        rest = feedback.goal + offset + slope @ (late.pop(0) - feedback.goal)
        tip = tip + share * (rest - tip)
        errors.append(np.linalg.norm(feedback.goal - tip))
        targets.append(feedback.target)
    last = round(20.0 / PERIOD)
    return np.array(errors[-last:]), np.array(targets[-last:]), float(np.linalg.norm(offset))


corners = st.fixed_dictionaries(
    {
        "gain": st.sampled_from([0.02, 0.2, 0.5]),
        "max_speed": st.sampled_from([0.002, 0.02, 100.0]),
        "max_correction": st.sampled_from([0.05, 0.5]),
        "feedforward_time": st.sampled_from([1.0, 3.0]),
    }
)


def feedback(chosen: dict[str, float]) -> GoalIntegrator:
    own = FeedbackSettings(**chosen, rest_time=SECONDS, timeout=SECONDS)
    return GoalIntegrator(own, np.array([0.1, -0.2, 0.7]), axes=3, start=0.0)


@given(
    corners,
    st.floats(0.3, 3.0),
    st.floats(0.2, 3.0),
    st.floats(0.0, 1.0),
    st.sampled_from([0.0, 1.5e-3]),
    st.integers(0, 1000),
)
@example(
    {"gain": 0.5, "max_speed": 100.0, "max_correction": 0.5, "feedforward_time": 1.0},
    3.0,
    3.0,
    1.0,
    1.5e-3,
    0,
)
@settings(max_examples=25, deadline=None)
def test_a_tip_that_goes_with_its_target_comes_to_the_goal_and_stays(
    chosen: dict[str, float], stretch: float, lag: float, dead: float, noise: float, seed: int
) -> None:
    """Up to three times too far, with lags and dead times of more than the trunk has."""
    rng = np.random.default_rng(seed)
    slope = stretch * (np.eye(3) + 0.2 * rng.uniform(-1.0, 1.0, (3, 3)))
    errors, targets, first = drive(feedback(chosen), slope, lag, dead, noise, seed)
    assert np.linalg.norm(np.ptp(targets, axis=0)) <= 0.01
    assert errors.max() <= max(0.01, 0.8 * first)


@given(corners, st.integers(0, 1000))
@settings(max_examples=25, deadline=None)
def test_a_tip_that_goes_another_way_is_not_chased(chosen: dict[str, float], seed: int) -> None:
    """At the ends of the ranges the tip may go away from its target, in one direction or in all."""
    slope = np.random.default_rng(seed).uniform(-1.0, 1.0, (3, 3))
    errors, _, first = drive(feedback(chosen), slope, 1.0, 0.3, 1.5e-3, seed)
    assert errors.max() <= 2.0 * first + 0.01
