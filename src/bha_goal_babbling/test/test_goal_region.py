"""The goal region: the grid's numbers, even draws, inside and outside."""

import math

import numpy as np
import pytest

from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.goal_region import GoalRegion

SHELL = GoalRegion((0.735, 0.78, 0.825), math.radians(36.0), 7, 15)
SURFACE = GoalRegion((0.78,), math.radians(36.0), 7, 15)


def spherical(positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return radius [m] and polar angle [rad] of positions."""
    radius = np.linalg.norm(positions, axis=1)
    return radius, np.arccos(positions[:, 2] / radius)


def test_grid_of_the_trunk() -> None:
    """315 goals: three radii, polar angles 5.14 to 36 degrees in 7 steps, 15 azimuths."""
    grid = SHELL.grid()
    assert grid.shape == (315, 3)
    radius, polar = spherical(grid)
    np.testing.assert_allclose(np.unique(radius.round(9)), [0.735, 0.78, 0.825])
    np.testing.assert_allclose(
        np.unique(np.degrees(polar).round(6)), np.arange(1, 8) * 36.0 / 7.0, atol=1e-5
    )
    azimuth = np.degrees(np.arctan2(grid[:, 1], grid[:, 0])) % 360.0
    assert len(np.unique((azimuth.round(6)) % 360.0)) == 15
    assert (grid[:, 2] > 0).all()


@pytest.mark.parametrize("region", [SHELL, SURFACE])
def test_draws_lie_within_the_region(region: GoalRegion) -> None:
    """Radius and polar angle keep to the bounds of the grid."""
    radius, polar = spherical(region.draw(5000, np.random.default_rng(0)))
    assert radius.min() >= region.radii[0] - 1e-12
    assert radius.max() <= region.radii[-1] + 1e-12
    assert polar.min() >= region.polar_min - 1e-9
    assert polar.max() <= region.polar_max + 1e-9


def test_draws_fill_the_volume_evenly() -> None:
    """Cells of equal volume get equally many: cubes of the radius, cosines, azimuths."""
    drawn = SHELL.draw(16000, np.random.default_rng(1))
    radius, polar = spherical(drawn)
    azimuth = np.arctan2(drawn[:, 1], drawn[:, 0])
    for values, low, high in (
        (radius**3, 0.735**3, 0.825**3),
        (np.cos(polar), math.cos(SHELL.polar_max), math.cos(SHELL.polar_min)),
        (azimuth, -math.pi, math.pi),
    ):
        counts, _ = np.histogram(values, bins=8, range=(low, high))
        np.testing.assert_allclose(counts, 2000, rtol=0.1)


def test_draws_on_a_surface_are_even_seen_along_z() -> None:
    """Rings of equal area in x and y get equally many."""
    drawn = SURFACE.draw(16000, np.random.default_rng(2))
    squared = np.sum(drawn[:, :2] ** 2, axis=1)
    counts, _ = np.histogram(squared, bins=8)
    np.testing.assert_allclose(counts, 2000, rtol=0.1)


def test_inside_and_outside() -> None:
    """The grid and the axis are inside; too far, too near, too much aside, or behind are not."""
    assert all(SHELL.why_outside(goal, 0.0) is None for goal in SHELL.grid())
    assert SHELL.why_outside(np.array([0.0, 0.0, 0.78]), 0.0) is None
    for position, reason in (
        ([0.0, 0.0, 0.9], "0.900 m from the base"),
        ([0.0, 0.0, 0.7], "0.700 m from the base"),
        ([0.6, 0.0, 0.5], "degrees off the z axis"),
        ([0.0, 0.0, -0.78], "180.0 degrees"),
    ):
        assert reason in str(SHELL.why_outside(np.array(position), 0.0))


def test_margin_is_a_distance() -> None:
    """A margin of 1 cm lets points 0.9 cm outside pass, and none 1.1 cm outside."""
    edge = 0.78 * np.array([math.sin(SHELL.polar_max), 0.0, math.cos(SHELL.polar_max)])
    outwards = np.array([math.cos(SHELL.polar_max), 0.0, -math.sin(SHELL.polar_max)])
    assert SHELL.why_outside(edge + 0.009 * outwards, 0.01) is None
    assert SHELL.why_outside(edge + 0.011 * outwards, 0.01) is not None
    assert SHELL.why_outside(np.array([0.0, 0.0, 0.834]), 0.01) is None
    assert SHELL.why_outside(np.array([0.0, 0.0, 0.836]), 0.01) is not None
    reach = 0.78 * math.sin(SURFACE.polar_max)
    assert SURFACE.why_too_far_aside(np.array([0.0, reach + 0.009]), 0.01) is None
    assert "aside" not in str(SURFACE.why_too_far_aside(np.array([0.0, reach + 0.011]), 0.01))
    assert SURFACE.why_too_far_aside(np.array([0.0, reach + 0.011]), 0.01) is not None


@pytest.mark.parametrize(
    ("radii", "polar", "steps", "azimuths", "named"),
    [
        ((), 0.5, 7, 15, "radii"),
        ((0.8, 0.7), 0.5, 7, 15, "radii"),
        ((-0.1, 0.7), 0.5, 7, 15, "radii"),
        ((math.nan,), 0.5, 7, 15, "radii"),
        ((0.7,), 0.0, 7, 15, "polar_max"),
        ((0.7,), 2.0, 7, 15, "polar_max"),
        ((0.7,), 0.5, 0, 15, "polar_steps"),
        ((0.7,), 0.5, 7, 0, "azimuth_steps"),
    ],
)
def test_refuses_impossible_regions(
    radii: tuple[float, ...], polar: float, steps: int, azimuths: int, named: str
) -> None:
    """The message names the bound."""
    with pytest.raises(InvalidConfigError, match=named):
        GoalRegion(radii, polar, steps, azimuths)
