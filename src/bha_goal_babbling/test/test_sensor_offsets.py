"""Offsets of the sensors: a Kalman filter to the letter, and what it finds."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.planar_arm import PlanarArm
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.sensor_offsets import SensorOffsets

ARM = PlanarArm(5)


def see(offsets: SensorOffsets, true: FloatArray, action: FloatArray, tip: FloatArray) -> None:
    """Learn from an action that reads `true` too much."""
    corrected = action + true - offsets.values
    offsets.learn(ARM.jacobian(corrected), tip - ARM.forward(corrected), 0.002**2)


def test_is_the_textbook_filter() -> None:
    """Ornstein-Uhlenbeck, seen as x - f = -J b + noise; covariance in Joseph's form."""
    rng = np.random.default_rng(0)
    spread, samples, variance = 0.3, 40.0, 0.05
    offsets = SensorOffsets(4, spread, samples)
    b, p, rho = np.zeros(4), spread**2 * np.eye(4), math.exp(-1 / samples)
    for _ in range(200):
        jacobian, seen = rng.standard_normal((2, 4)), rng.standard_normal(2)
        offsets.learn(jacobian, seen + jacobian @ b * rho, variance)  # what rho b leaves over
        b, p = rho * b, rho**2 * p + (1 - rho**2) * spread**2 * np.eye(4)
        h = -jacobian
        gain = p @ h.T @ np.linalg.inv(h @ p @ h.T + variance * np.eye(2))
        b = b + gain @ (seen - h @ b)
        keep = np.eye(4) - gain @ h
        p = keep @ p @ keep.T + variance * gain @ gain.T
        np.testing.assert_allclose(offsets.values, b, atol=1e-10)
        np.testing.assert_allclose(offsets.state().arrays["covariance"], p, atol=1e-10)


def test_finds_a_constant_offset() -> None:
    """Five angles, seen in two coordinates of a tip that moves about."""
    rng = np.random.default_rng(1)
    true = 0.1 * rng.standard_normal(5)
    offsets = SensorOffsets(5, 0.1, 1e5)
    errors = []
    for _ in range(400):
        action = rng.uniform(-1.5, 1.5, 5)
        see(offsets, true, action, ARM.forward(action) + 0.002 * rng.standard_normal(2))
        errors.append(np.abs(offsets.values - true).max())
    assert errors[0] > 0.05
    assert max(errors[-100:]) < 0.01


def test_follows_offsets_that_wander() -> None:
    """Closely, and it knows how closely: the errors are as large as its covariance says."""
    rng = np.random.default_rng(2)
    spread, samples = 0.1, 300.0
    rho = math.exp(-1 / samples)
    true, offsets = spread * rng.standard_normal(5), SensorOffsets(5, spread, samples)
    squares, normalised = [], []
    for t in range(4000):
        true = rho * true + spread * math.sqrt(1 - rho**2) * rng.standard_normal(5)
        action = rng.uniform(-1.5, 1.5, 5)
        see(offsets, true, action, ARM.forward(action) + 0.002 * rng.standard_normal(2))
        if t > 100:
            error = offsets.values - true
            covariance = offsets.state().arrays["covariance"]
            squares.append(error @ error / 5)
            normalised.append(error @ np.linalg.solve(covariance, error) / 5)
    assert math.sqrt(np.mean(squares)) < 0.25 * spread
    assert 0.7 < np.mean(normalised) < 1.4


def test_what_is_not_seen_is_forgotten() -> None:
    """Without any slope the offsets fall to zero and are as unknown as at first."""
    offsets = SensorOffsets(3, 0.2, 50.0)
    for _ in range(20):
        offsets.learn(np.eye(3), -0.3 - offsets.values, 0.01)
    known = offsets.values.copy()
    for _ in range(50):
        offsets.learn(np.zeros((3, 3)), np.ones(3), 0.01)
    np.testing.assert_allclose(offsets.values, known * math.exp(-1.0))
    for _ in range(2000):
        offsets.learn(np.zeros((3, 3)), np.ones(3), 0.01)
    np.testing.assert_allclose(offsets.state().arrays["covariance"], 0.04 * np.eye(3), rtol=1e-12)


@given(seed=st.integers(0, 1000), m=st.integers(1, 9), n=st.integers(1, 3))
def test_the_covariance_stays_one(seed: int, m: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    offsets = SensorOffsets(m, 0.01, 20.0)
    for _ in range(50):
        offsets.learn(rng.standard_normal((n, m)), rng.standard_normal(n), 1e-6)
    covariance = offsets.state().arrays["covariance"]
    np.testing.assert_array_equal(covariance, covariance.T)
    eigenvalues = np.linalg.eigvalsh(covariance)
    assert eigenvalues[0] > 0.0
    assert eigenvalues[-1] < 0.01**2 * (1.0 + 1e-9)


def test_sensors_without_offsets_get_none() -> None:
    offsets = SensorOffsets(5, 0.0, 100.0)
    for _ in range(10):
        see(offsets, np.full(5, 0.3), np.ones(5), ARM.forward(np.ones(5)))
    np.testing.assert_array_equal(offsets.values, np.zeros(5))


def test_continues_bit_for_bit() -> None:
    rng = np.random.default_rng(3)
    offsets = SensorOffsets(5, 0.1, 77.7)
    tips = rng.uniform(-1, 1, (60, 2))
    for tip in tips[:30]:
        see(offsets, np.zeros(5), np.ones(5), tip)
    state = offsets.state()
    twins = [SensorOffsets.restore(state), SensorOffsets.restore(state)]
    for tip in tips[30:]:
        for each in (offsets, *twins):
            see(each, np.zeros(5), np.ones(5), tip)
    for twin in twins:
        np.testing.assert_array_equal(offsets.values, twin.values)
        np.testing.assert_array_equal(
            offsets.state().arrays["covariance"], twin.state().arrays["covariance"]
        )


@pytest.mark.parametrize(
    "broken",
    [
        {"values": np.zeros(4)},
        {"values": np.zeros((5, 1))},
        {"values": np.full(5, np.nan)},
        {"covariance": np.eye(4)},
        {"covariance": np.zeros(5)},
        {"covariance": np.full((5, 5), np.nan)},
    ],
    ids=lambda broken: f"{next(iter(broken))}-{np.shape(next(iter(broken.values())))}",
)
def test_refuses_broken_snapshots(broken: dict[str, FloatArray]) -> None:
    whole = SensorOffsets(5, 0.1, 100.0).state()
    with pytest.raises(GoalBabblingError):
        SensorOffsets.restore(SavedState({**whole.arrays, **broken}, whole.settings))
