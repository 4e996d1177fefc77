"""Planar arm: kinematics, Jacobian, home postures, goals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bha_goal_babbling.errors import InvalidArrayError, InvalidConfigError
from bha_goal_babbling.planar_arm import PlanarArm


def test_known_postures() -> None:
    """Stretched out, turned up, and folded by a right angle."""
    arm = PlanarArm(4, length=2.0)
    np.testing.assert_allclose(arm.forward(np.zeros(4)), [2.0, 0.0])
    np.testing.assert_allclose(arm.forward([np.pi / 2, 0, 0, 0]), [0.0, 2.0], atol=1e-15)
    np.testing.assert_allclose(arm.forward([0, 0, np.pi / 2, 0]), [1.0, 1.0], atol=1e-15)


@given(st.integers(1, 30), st.integers(0, 2**32))
def test_jacobian_is_the_derivative(joints: int, seed: int) -> None:
    """The formula agrees with central differences."""
    arm, angles = PlanarArm(joints), np.random.default_rng(seed).uniform(-3, 3, joints)
    step = 1e-6
    shifted = step * np.eye(joints)
    numerical = (arm.forward(angles + shifted) - arm.forward(angles - shifted)).T / (2 * step)
    np.testing.assert_allclose(arm.jacobian(angles), numerical, atol=1e-8)


def test_many_postures_at_once() -> None:
    """Rows are postures."""
    arm, angles = PlanarArm(5), np.random.default_rng(0).uniform(-1, 1, (7, 5))
    singles = [arm.forward(posture) for posture in angles]
    np.testing.assert_allclose(arm.forward(angles), singles, atol=1e-15)


@pytest.mark.parametrize("joints", [2, 3, 5, 20, 50])
@pytest.mark.parametrize("branch", [1, -1])
def test_home_has_evenly_spread_headings(joints: int, branch: int) -> None:
    """The tip is at (0.7, 0), headings fall in equal steps, the arch lies on the branch's side."""
    arm = PlanarArm(joints)
    home = arm.home(0.7, branch)
    np.testing.assert_allclose(arm.forward(home), [0.7, 0.0], atol=1e-12)
    np.testing.assert_allclose(home[1:], home[1], atol=1e-12)
    assert branch * home[0] > 0


def test_goal_grid() -> None:
    """Seven by eleven goals, corners included."""
    goals = PlanarArm(2).goal_grid()
    assert goals.shape == (77, 2)
    np.testing.assert_allclose(goals.min(axis=0), [0.2, -0.5])
    np.testing.assert_allclose(goals.max(axis=0), [0.8, 0.5])


def test_refuses_what_does_not_fit() -> None:
    """Wrong numbers of angles, arms without joints, homes out of reach."""
    with pytest.raises(InvalidArrayError, match="angles"):
        PlanarArm(3).forward(np.zeros(4))
    with pytest.raises(InvalidConfigError, match="joints"):
        PlanarArm(0)
    with pytest.raises(InvalidConfigError, match="reach"):
        PlanarArm(3).home(1.0)
    with pytest.raises(InvalidConfigError, match="2 joints"):
        PlanarArm(1).home(0.7)
