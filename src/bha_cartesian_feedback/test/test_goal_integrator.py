"""Integral control in goal space, on a plant that follows its target with errors and a lag."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

from bha_cartesian_feedback.goal_integrator import FeedbackSettings, GoalIntegrator

Array = NDArray[np.float64]

PERIOD = 0.1
GOAL = np.array([0.1, -0.2, 0.7])


class Trunk:
    """A tip that goes where an imperfect inverse model puts it: affine in the target, and late."""

    def __init__(
        self, lag: float, shear: float = 0.15, offset: float = 0.02, seed: int = 0
    ) -> None:
        rng = np.random.default_rng(seed)
        self._map = np.eye(3) + shear * rng.uniform(-1.0, 1.0, (3, 3))
        self._offset = offset * rng.uniform(-1.0, 1.0, 3)
        self._share = 1.0 - np.exp(-PERIOD / lag)
        self.tip = np.array([0.0, 0.0, 0.75])

    def follow(self, target: Array) -> Array:
        rest = GOAL + self._map @ (target - GOAL) + self._offset
        self.tip = self.tip + self._share * (rest - self.tip)
        return self.tip


def integrator(
    axes: int = 3,
    start: float = 100.0,
    tolerance: float = 0.0,
    timeout: float = 0.0,
    **changes: Any,
) -> GoalIntegrator:
    return GoalIntegrator(
        FeedbackSettings(**changes),
        GOAL,
        axes=axes,
        start=start,
        tolerance=tolerance,
        timeout=timeout,
    )


def run(feedback: GoalIntegrator, trunk: Trunk, seconds: float, start: float = 100.0) -> Array:
    """Let the tip follow for a while; return the errors [m]."""
    errors = []
    for tick in range(1, round(seconds / PERIOD) + 1):
        target = feedback.update(start + tick * PERIOD, trunk.tip)
        trunk.follow(target)
        errors.append(feedback.error)
    return np.array(errors)


@pytest.mark.parametrize("gain", [0.1, 0.2, 0.35, 0.5])
@pytest.mark.parametrize("lag", [0.3, 1.0, 1.5])
@pytest.mark.parametrize("seed", [0, 1])
def test_the_error_goes_away(gain: float, lag: float, seed: int) -> None:
    """For every gain that the settings allow, up to the lag that the trunk has."""
    errors = run(integrator(gain=gain, max_speed=1.0), Trunk(lag, seed=seed), 120.0)
    assert errors[-1] < 1e-4
    assert errors[30:].max() < 0.2  # does not swing up on the way


def test_without_gain_it_stays() -> None:
    """The test above can fail: the error is that of the inverse model."""
    assert run(integrator(gain=0.0), Trunk(1.0), 120.0)[-1] > 5e-3


@pytest.mark.parametrize("lag", [0.3, 1.0])
def test_the_largest_gain_has_a_margin(lag: float) -> None:
    """Half a second of dead time on top does not make it swing up either."""
    feedback, trunk = integrator(gain=0.5, max_speed=1.0), Trunk(lag)
    late, errors = [trunk.tip] * 5, []
    for tick in range(1, 1200):
        late.append(trunk.follow(feedback.update(100.0 + tick * PERIOD, late.pop(0))))
        errors.append(feedback.error)
    assert errors[-1] < 1e-4


@given(hnp.arrays(np.float64, (30, 3), elements=st.floats(-10.0, 10.0)))
@settings(max_examples=50, deadline=None)
def test_the_target_stays_near_the_goal_and_slow(tips: Array) -> None:
    """Wherever the tip is seen: anti-windup in size and in speed."""
    feedback = integrator(max_correction=0.15, max_speed=0.02, feedforward_time=1.0)
    before = feedback.target
    np.testing.assert_array_equal(before, GOAL)
    for tick, tip in enumerate(tips, start=1):
        after = feedback.update(100.0 + tick * PERIOD, tip)
        np.testing.assert_array_equal(after, feedback.target)
        assert np.linalg.norm(after - GOAL) <= 0.15 + 1e-9
        assert np.linalg.norm(after - before) <= 0.02 * PERIOD + 1e-9
        before = after


def test_a_goal_out_of_reach_does_not_wind_up() -> None:
    """However long the tip was held back, the target comes back from its limit at once."""
    held, feedback = np.array([0.0, 0.0, 0.7]), integrator(max_correction=0.1)
    for tick in range(1, 3000):
        feedback.update(100.0 + tick * PERIOD, held)
    assert np.linalg.norm(feedback.target - GOAL) == pytest.approx(0.1)
    beyond = GOAL + (GOAL - held)
    feedback.update(400.0, beyond)
    assert np.linalg.norm(feedback.target - GOAL) < 0.1 - 0.9 * 0.02 * PERIOD


@pytest.mark.parametrize("gain", [0.05, 0.2, 0.5])
@pytest.mark.parametrize("wait", [1.0, 3.0])
def test_what_leads_nowhere_is_taken_back(gain: float, wait: float) -> None:
    """A tip that cannot come nearer than 2 cm: the target tries 4 cm and goes back, ever slower."""
    feedback = integrator(gain=gain, max_speed=1.0, max_correction=0.5, feedforward_time=wait)
    held, away = GOAL + np.array([0.02, 0.0, 0.0]), []
    for tick in range(1, 6000):
        away.append(np.linalg.norm(feedback.update(100.0 + tick * PERIOD, held) - GOAL))
    assert max(away) < 2.0 * (0.02 + 0.002) + 2 * gain * 0.02  # as far as it comes until a check
    assert min(away[300:]) < 0.005
    assert feedback.gain < gain


@pytest.mark.parametrize("gain", [0.05, 0.2, 0.5])
def test_a_tip_that_is_led_away_comes_back(gain: float) -> None:
    """Beyond 1 cm of correction the answer is another posture: it does not stay there."""
    feedback = integrator(gain=gain, max_speed=0.02, max_correction=0.5)
    errors, tip = [], GOAL + np.array([0.02, 0.0, 0.0])
    for tick in range(1, 3000):
        correction = feedback.update(100.0 + tick * PERIOD, tip) - GOAL
        rest = 0.02 + 0.5 * correction[0] if correction[0] > -0.01 else 0.10
        tip = tip + 0.1 * (GOAL + np.array([rest, 0.0, 0.0]) - tip)
        errors.append(feedback.error)
    assert np.median(errors[-1000:]) < 0.021


def test_goes_on_after_it_went_back() -> None:
    """What was out of reach may come into reach, as when creep or a load goes."""
    feedback, stuck = integrator(gain=0.2, max_correction=0.5), GOAL + np.array([0.02, 0.0, 0.0])
    for tick in range(1, 1000):
        feedback.update(100.0 + tick * PERIOD, stuck)
    errors = run(feedback, Trunk(1.0), 600.0, start=200.0)
    assert errors[-1] < 2e-3


def test_a_gap_in_the_stream_of_tips_does_not_make_the_target_jump() -> None:
    """What the tip did meanwhile is not known, so it is not integrated over the gap."""
    feedback = integrator(feedforward_time=1.0)
    feedback.update(100.1, GOAL + 0.05)
    before = feedback.target
    feedback.update(120.0, GOAL + 0.05)
    assert np.linalg.norm(feedback.target - before) <= 0.02 * 1.0 + 1e-9


def test_waits_for_the_feed_forward_movement() -> None:
    feedback = integrator(feedforward_time=3.0)
    for tick in range(1, 31):
        np.testing.assert_array_equal(feedback.update(100.0 + tick * PERIOD, np.zeros(3)), GOAL)
    assert not np.array_equal(feedback.update(103.2, np.zeros(3)), GOAL)


def test_two_axes_ignore_z() -> None:
    """The target's z stays as given, and an error of it neither counts nor delays."""
    feedback = integrator(axes=2, feedforward_time=1.0)
    for tick in range(1, 100):
        tip = GOAL + np.array([0.001, 0.0, 0.3])
        target = feedback.update(100.0 + tick * PERIOD, tip)
        assert target[2] == GOAL[2]
        assert feedback.error == pytest.approx(0.001)
    assert feedback.arrived


def test_three_axes_count_z() -> None:
    feedback = integrator(axes=3)
    feedback.update(100.1, GOAL + np.array([0.0, 0.0, 0.3]))
    assert feedback.error == pytest.approx(0.3)


def test_error_and_time_before_the_first_tip() -> None:
    feedback = integrator()
    assert np.isnan(feedback.error)
    assert feedback.elapsed == 0.0
    assert not feedback.arrived
    assert not feedback.done


class TestEnd:
    """Arrived, or out of time."""

    def test_arrives_after_staying_for_the_rest_time(self) -> None:
        feedback = integrator(tolerance=0.01, rest_time=3.0)
        for tick in range(1, 30):
            feedback.update(100.0 + tick * PERIOD, GOAL + 0.005)
            assert not feedback.done
        feedback.update(103.0, GOAL + 0.005)
        assert feedback.arrived
        assert feedback.done
        assert feedback.elapsed == pytest.approx(3.0)

    def test_leaving_begins_the_rest_anew(self) -> None:
        feedback = integrator(tolerance=0.01, rest_time=3.0)
        for tick in range(1, 300):
            tip = GOAL + (0.02 if tick % 29 < 5 else 0.0)
            feedback.update(100.0 + tick * PERIOD, tip)
            assert not feedback.arrived

    def test_the_trackers_noise_does_not_keep_it_from_arriving(self) -> None:
        """Hardly one position in three is seen within 2 mm of the goal where the tip stays."""
        feedback, rng = integrator(feedforward_time=60.0), np.random.default_rng(0)
        while not feedback.done:
            feedback.update(100.1 + feedback.elapsed, GOAL + 1.5e-3 * rng.standard_normal(3))
        assert feedback.arrived
        assert feedback.elapsed < 10.0

    def test_a_tip_that_was_not_seen_has_not_stayed(self) -> None:
        """Nobody knows where it was between two positions far apart in time."""
        feedback = integrator(tolerance=0.01, rest_time=3.0)
        feedback.update(101.0, GOAL)
        for time in (105.0, 109.0, 113.0):
            feedback.update(time, GOAL)
            assert not feedback.arrived

    @pytest.mark.parametrize("rest_time", [0.0, 1.0])
    def test_is_not_there_while_it_is_elsewhere(self, rest_time: float) -> None:
        """Also where no rest is asked for."""
        feedback = integrator(rest_time=rest_time)
        assert not feedback.arrived
        for tick in range(1, 50):
            feedback.update(100.0 + tick * PERIOD, np.zeros(3))
            assert not feedback.arrived

    def test_without_a_rest_time_it_is_there_at_once(self) -> None:
        feedback = integrator(rest_time=0.0)
        feedback.update(100.1, GOAL)
        assert feedback.arrived

    def test_runs_out_of_time(self) -> None:
        feedback = integrator(timeout=5.0)
        for tick in range(1, 50):
            feedback.update(100.0 + tick * PERIOD, np.zeros(3))
            assert not feedback.done
        feedback.update(105.0, np.zeros(3))
        assert feedback.done
        assert not feedback.arrived

    def test_takes_tolerance_and_timeout_of_the_settings_for_zero(self) -> None:
        feedback = integrator(timeout=0.0)
        feedback.update(100.0 + FeedbackSettings().timeout - 0.1, np.zeros(3))
        assert not feedback.done
        feedback.update(100.0 + FeedbackSettings().timeout, np.zeros(3))
        assert feedback.done

    def test_a_whole_movement_arrives_within_the_default_time(self) -> None:
        """As on the robot: an inverse model 15 mm off, a lag of one second, the defaults."""
        feedback, trunk = integrator(), Trunk(1.0, offset=0.015)
        run(feedback, trunk, 30.0)
        assert feedback.error < 0.002


@pytest.mark.parametrize(
    "wrong", [{"gain": -0.1}, {"max_correction": 0.6}, {"timeout": 0.0}, {"rest_time": -1.0}]
)
def test_settings_out_of_range(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        FeedbackSettings(**wrong)
