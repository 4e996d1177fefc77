"""Constant-curvature kinematics: bellows lengths to tip, as an analytic reference.

Each segment is taken for an arc. With bellows at 0, 120 and 240 degrees on a circle of radius b,
lengths l1, l2, l3 and mean length l (Rolf & Steil 2012):

    g     = sqrt(l1^2 + l2^2 + l3^2 - l1 l2 - l1 l3 - l2 l3)
    theta = 2 g/(3 b)                                     bending angle
    phi   = atan2(sqrt(3) (l3 - l2), l2 + l3 - 2 l1)      direction: away from the long bellows
    p     = l sinc(theta/2) (sin(theta/2) cos phi, sin(theta/2) sin phi, cos(theta/2))

with sinc(a) = sin(a)/a. Frames are `bha_base` and alike: z along the axis, away from the base, x
towards bellows 1. Neither gravity nor twist is in it: the robot differs from it by about 1 cm.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from bha_common import bellows
from bha_sim.parameter_checks import Array


def segment_pose(lengths: ArrayLike, radius: float) -> tuple[Array, Array]:
    """End of one segment, seen from its base.

    Parameters
    ----------
    lengths : Bellows lengths [m], shape (..., 3).
    radius : Radius of the bellows circle [m].

    Returns
    -------
    position : End of the segment [m], shape (..., 3).
    rotation : Orientation of the end, columns its axes [-], shape (..., 3, 3).
    """
    lengths = np.asarray(lengths, dtype=np.float64)
    l1, l2, l3 = np.moveaxis(lengths, -1, 0)
    east, north = l2 + l3 - 2.0 * l1, np.sqrt(3.0) * (l3 - l2)
    # The g of the formula is half the length of this vector.
    half = np.hypot(east, north) / (6.0 * radius)
    phi = np.arctan2(north, east)
    chord = lengths.mean(axis=-1) * np.sinc(half / np.pi)
    position = np.stack(
        [
            chord * np.sin(half) * np.cos(phi),
            chord * np.sin(half) * np.sin(phi),
            chord * np.cos(half),
        ],
        axis=-1,
    )
    return position, _bend(2.0 * half, phi)


def tip_pose(lengths: ArrayLike, radii: ArrayLike, tool_length: float) -> tuple[Array, Array]:
    """Tip of the trunk: three segments and the tool.

    Parameters
    ----------
    lengths : Bellows lengths [m], shape (..., 9), base segment first.
    radii : Radius of each segment's bellows circle [m], shape (3,).
    tool_length : Distance from the last segment's end to the tip [m].

    Returns
    -------
    position : Tip in `bha_base` [m], shape (..., 3).
    rotation : Orientation of the tip, columns its axes [-], shape (..., 3, 3).
    """
    lengths = np.asarray(lengths, dtype=np.float64)
    chambers = bellows.CHAMBERS
    position = np.zeros((*lengths.shape[:-1], 3))
    rotation = np.broadcast_to(np.eye(3), (*lengths.shape[:-1], 3, 3))
    for segment, radius in enumerate(np.asarray(radii, dtype=np.float64)):
        part = lengths[..., segment * chambers : (segment + 1) * chambers]
        end, turn = segment_pose(part, radius)
        position = position + np.einsum("...ij,...j->...i", rotation, end)
        rotation = rotation @ turn
    return position + tool_length * rotation[..., 2], rotation


def _bend(theta: Array, phi: Array) -> Array:
    """Rotation by theta that tilts z towards the direction phi, without twist."""
    c, s, u, v = np.cos(theta), np.sin(theta), np.cos(phi), np.sin(phi)
    rows = [
        [1.0 - (1.0 - c) * u * u, -(1.0 - c) * u * v, s * u],
        [-(1.0 - c) * u * v, 1.0 - (1.0 - c) * v * v, s * v],
        [-s * u, -s * v, c],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
