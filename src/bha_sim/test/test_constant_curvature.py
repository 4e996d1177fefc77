"""Constant-curvature kinematics: known postures, symmetries and smoothness."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bha_sim.constant_curvature import segment_pose, tip_pose

RADII = (0.100, 0.093, 0.079)
LENGTHS = arrays(np.float64, (9,), elements=st.floats(0.10, 0.35))


def test_equal_lengths_are_straight():
    position, rotation = tip_pose(np.full(9, 0.2), RADII, 0.2)
    np.testing.assert_allclose(position, [0.0, 0.0, 0.8], atol=1e-15)
    np.testing.assert_allclose(rotation, np.eye(3), atol=1e-15)


def test_a_right_angle_is_a_quarter_of_a_circle():
    # Bending by theta in the direction of bellows 1 shortens it by b theta and stretches the
    # others by b theta/2.
    radius, mean, theta = 0.1, 0.2, np.pi / 2
    lengths = mean + radius * theta * np.array([-1.0, 0.5, 0.5])
    position, rotation = segment_pose(lengths, radius)
    arc = mean / theta
    np.testing.assert_allclose(position, [arc, 0.0, arc], atol=1e-15)
    np.testing.assert_allclose(rotation[:, 2], [1.0, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("bellows", range(3))
def test_the_trunk_bends_away_from_the_longest_bellows(bellows):
    lengths = np.full(3, 0.2)
    lengths[bellows] = 0.22
    position, _ = segment_pose(lengths, 0.1)
    angle = 2 * np.pi * bellows / 3
    away = -np.array([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(position[:2] / np.linalg.norm(position[:2]), away, atol=1e-12)


@given(LENGTHS)
def test_rotations_are_rotations(lengths):
    _, rotation = tip_pose(lengths, RADII, 0.2)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(rotation) == pytest.approx(1.0)


@given(LENGTHS)
def test_renaming_the_bellows_turns_the_trunk(lengths):
    turned = np.roll(lengths.reshape(3, 3), 1, axis=1).ravel()
    c, s = np.cos(2 * np.pi / 3), np.sin(2 * np.pi / 3)
    third = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    position, rotation = tip_pose(lengths, RADII, 0.2)
    position_turned, rotation_turned = tip_pose(turned, RADII, 0.2)
    np.testing.assert_allclose(position_turned, third @ position, atol=1e-9)
    np.testing.assert_allclose(rotation_turned, third @ rotation @ third.T, atol=1e-9)


@given(LENGTHS)
def test_swapping_bellows_2_and_3_mirrors_the_trunk(lengths):
    mirrored = lengths.reshape(3, 3)[:, [0, 2, 1]].ravel()
    position, _ = tip_pose(lengths, RADII, 0.2)
    position_mirrored, _ = tip_pose(mirrored, RADII, 0.2)
    np.testing.assert_allclose(position_mirrored, position * [1.0, -1.0, 1.0], atol=1e-9)


@given(LENGTHS, st.integers(0, 2**32))
def test_many_at_once_are_as_one_by_one(lengths, seed):
    many = lengths * np.random.default_rng(seed).uniform(0.9, 1.1, (4, 2, 9))
    positions, rotations = tip_pose(many, RADII, 0.2)
    assert positions.shape == (4, 2, 3)
    assert rotations.shape == (4, 2, 3, 3)
    one, turn = tip_pose(many[3, 1], RADII, 0.2)
    np.testing.assert_allclose(positions[3, 1], one, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(rotations[3, 1], turn, rtol=1e-12, atol=1e-15)


def test_straight_is_no_singularity():
    home = np.full(9, 0.2)
    for step in (1e-4, 1e-7, 1e-10):
        moved = home.copy()
        moved[4] += step
        position, _ = tip_pose(moved, RADII, 0.2)
        # The middle segment turns by 2 step/(3 b) about its own middle, with the rest beyond it.
        bend = 2 * step / (3 * RADII[1])
        sideways = np.hypot(position[0], position[1])
        assert sideways == pytest.approx(bend * (0.1 + 0.2 + 0.2), rel=1e-3)


def test_stretching_is_the_hard_direction():
    home, step = np.full(9, 0.2), 1e-6
    moved = home + step * np.vstack([np.eye(9), -np.eye(9)])
    tips, _ = tip_pose(moved, RADII, 0.2)
    singular = np.linalg.svd((tips[:9] - tips[9:]) / (2 * step), compute_uv=False)
    assert singular[0] == pytest.approx(singular[1])
    assert singular[2] == pytest.approx(1.0)
    assert 5.0 < singular[0] / singular[2] < 8.0
