"""Where the tip is to go: a cap of a spherical shell around the base, its grid and its inside.

Spherical coordinates about the base: radius r, polar angle from the z axis (the trunk at rest),
azimuth from the x axis. The trunk bends to the side easily and stretches hardly, so what it
reaches is such a shell.
"""

import math
from dataclasses import dataclass

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import InvalidConfigError

_TOLERANCE = 1e-9


@dataclass(frozen=True)
class GoalRegion:
    """Goals with a radius and a polar angle within bounds, at any azimuth.

    Attributes
    ----------
    radii : tuple of float
        Radii of the grid [m], rising; a single one makes the shell a sphere's surface.
    polar_max : float
        Largest polar angle [rad]; the smallest is `polar_max / polar_steps`.
    polar_steps : int
        Number of polar angles of the grid, evenly spaced.
    azimuth_steps : int
        Number of azimuths of the grid, evenly spaced over the full turn.
    """

    radii: tuple[float, ...]
    polar_max: float
    polar_steps: int
    azimuth_steps: int

    def __post_init__(self) -> None:
        """Check the bounds.

        Raises
        ------
        InvalidConfigError
            Naming what is wrong and what would be right.
        """
        rising = all(a < b for a, b in zip(self.radii, self.radii[1:], strict=False))
        finite = all(math.isfinite(radius) for radius in self.radii)
        if not (self.radii and rising and finite and self.radii[0] > 0):
            raise InvalidConfigError(f"radii must be rising and above 0 m, got {self.radii}")
        if not 0 < self.polar_max < math.pi / 2:
            raise InvalidConfigError(
                f"polar_max must be above 0 and below 90 degrees, got {self.polar_max} rad"
            )
        if self.polar_steps < 1 or self.azimuth_steps < 1:
            raise InvalidConfigError(
                "polar_steps and azimuth_steps must be at least 1, "
                f"got {self.polar_steps} and {self.azimuth_steps}"
            )

    @property
    def polar_min(self) -> float:
        """Smallest polar angle [rad]."""
        return self.polar_max / self.polar_steps

    def grid(self) -> FloatArray:
        """Return the grid's positions [m], shape (radii * polar_steps * azimuth_steps, 3)."""
        polar = self.polar_max * np.arange(1, self.polar_steps + 1) / self.polar_steps
        azimuth = 2.0 * np.pi * np.arange(self.azimuth_steps) / self.azimuth_steps
        r, p, a = np.meshgrid(np.array(self.radii), polar, azimuth, indexing="ij")
        return _positions(r.ravel(), p.ravel(), a.ravel())

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return random positions within the region [m], shape (count, 3).

        They are uniform in the volume; on a single radius they are uniform in x and y.

        Parameters
        ----------
        count : int
            How many.
        rng : numpy.random.Generator
            Source of randomness.
        """
        share = rng.random((3, count))
        azimuth = 2.0 * np.pi * share[2]
        if len(self.radii) == 1:
            # Equal areas in the x-y plane: the square of sin(polar) is uniform.
            low, high = np.sin(self.polar_min) ** 2, np.sin(self.polar_max) ** 2
            polar = np.arcsin(np.sqrt(low + share[1] * (high - low)))
            return _positions(np.full(count, self.radii[0]), polar, azimuth)
        inner, outer = self.radii[0] ** 3, self.radii[-1] ** 3
        radius = np.cbrt(inner + share[0] * (outer - inner))
        low, high = np.cos(self.polar_max), np.cos(self.polar_min)
        polar = np.arccos(low + share[1] * (high - low))
        return _positions(radius, polar, azimuth)

    def why_too_far_aside(self, point: FloatArray, margin: float) -> str | None:
        """Return why a point seen along z, shape (2,) [m], is outside of the region, or None.

        Parameters
        ----------
        point : array
            Its x and y [m], shape (2,).
        margin : float
            How far outside a point may be to count as inside [m].
        """
        lateral = math.hypot(*point)
        reach = self.radii[-1] * math.sin(self.polar_max) + margin
        if lateral > reach + _TOLERANCE:
            return f"it is {lateral:.3f} m off the z axis; up to {reach:.3f} m can be reached"
        return None

    def why_outside(self, position: FloatArray, margin: float) -> str | None:
        """Return why a position is outside of the region, or None if it is inside.

        The cone about the z axis that the grid leaves out counts as inside.

        Parameters
        ----------
        position : array
            Position [m], shape (3,).
        margin : float
            How far outside a position may be to count as inside [m].
        """
        radius = float(np.linalg.norm(position))
        low, high = self.radii[0] - margin, self.radii[-1] + margin
        if not low - _TOLERANCE <= radius <= high + _TOLERANCE:
            return f"it is {radius:.3f} m from the base; {low:.3f} to {high:.3f} m can be reached"
        polar = math.atan2(math.hypot(position[0], position[1]), position[2])
        # An excess angle puts the position that much of an arc beyond the cone's surface.
        if (polar - self.polar_max) * radius > margin + _TOLERANCE:
            return (
                f"it is {math.degrees(polar):.1f} degrees off the z axis; "
                f"up to {math.degrees(self.polar_max):.1f} degrees can be reached"
            )
        return None


def _positions(radius: FloatArray, polar: FloatArray, azimuth: FloatArray) -> FloatArray:
    lateral = radius * np.sin(polar)
    return np.stack(
        [lateral * np.cos(azimuth), lateral * np.sin(azimuth), radius * np.cos(polar)], axis=-1
    )
