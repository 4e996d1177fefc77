"""A planar arm with m equal links, the usual test of goal babbling: actions are joint angles."""

import numpy as np
from numpy.typing import ArrayLike

from bha_goal_babbling.arrays import FloatArray, vector
from bha_goal_babbling.errors import InvalidArrayError, InvalidConfigError


class PlanarArm:
    """Kinematics of an arm in the plane, its base at the origin, stretched out along x at 0.

    Parameters
    ----------
    joints : int
        Number m of joints and links, at least 1.
    length : float
        Length of the whole arm [m].
    """

    def __init__(self, joints: int, length: float = 1.0) -> None:
        if joints < 1 or not length > 0:
            raise InvalidConfigError(
                f"joints must be at least 1 and length above 0, got {joints} and {length}"
            )
        self.joints = joints
        self.length = float(length)

    def forward(self, angles: ArrayLike) -> FloatArray:
        """Return where the tip is.

        Parameters
        ----------
        angles : array_like
            Joint angles [rad], shape (m,) or (N, m); each is relative to the link before.

        Returns
        -------
        array
            Tip [m], shape (2,) or (N, 2): the mean of the links' unit vectors times the length.
        """
        headings = self._checked(angles).cumsum(axis=-1)
        tip = np.empty((*headings.shape[:-1], 2))
        np.add.reduce(np.cos(headings), axis=-1, out=tip[..., 0])
        np.add.reduce(np.sin(headings), axis=-1, out=tip[..., 1])
        tip *= self.length / self.joints
        return tip

    def jacobian(self, angles: ArrayLike) -> FloatArray:
        """Return the derivative of the tip by the angles [m/rad], shape (2, m).

        Joint i turns all links from i on: column i is the vector from joint i to the tip, turned
        by 90 degrees.

        Parameters
        ----------
        angles : array_like
            Joint angles [rad], shape (m,).
        """
        headings = np.cumsum(vector("angles", angles, self.joints))
        link = self.length / self.joints
        x = link * np.cumsum(np.cos(headings)[::-1])[::-1]
        y = link * np.cumsum(np.sin(headings)[::-1])[::-1]
        return np.stack([-y, x])

    def home(self, reach: float = 0.7, branch: int = 1) -> FloatArray:
        """Return joint angles [rad], shape (m,), with the tip at (reach * length, 0).

        The links' headings are spread evenly from +a to -a, an even arch.

        Parameters
        ----------
        reach : float
            Distance of the tip as a share of the length, above 0 and below 1.
        branch : int
            +1 for the arch above the x axis, -1 for the one below.
        """
        if not 0 < reach < 1 or branch not in (1, -1) or self.joints < 2:
            raise InvalidConfigError(
                "home needs 0 < reach < 1, branch 1 or -1, and 2 joints or more, "
                f"got {reach}, {branch} and {self.joints}"
            )
        spread = np.linspace(1.0, -1.0, self.joints)
        # The mean of cos(a * spread) falls from 1 to at most 0 while a grows from 0 to pi.
        low, high = 0.0, np.pi
        for _ in range(80):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if np.cos(middle * spread).mean() > reach else (low, middle)
        return np.diff(branch * high * spread, prepend=0.0)

    def goal_grid(
        self,
        x: tuple[float, float] = (0.2, 0.8),
        y: tuple[float, float] = (-0.5, 0.5),
        spacing: float = 0.1,
    ) -> FloatArray:
        """Return goals on a rectangular grid [m], shape (G, 2).

        Parameters
        ----------
        x, y : tuple of float
            First and last coordinate [m].
        spacing : float
            Distance of neighbours [m]; the spans are whole multiples of it, or nearly.
        """
        columns = np.linspace(*x, round((x[1] - x[0]) / spacing) + 1)
        rows = np.linspace(*y, round((y[1] - y[0]) / spacing) + 1)
        return np.stack(np.meshgrid(columns, rows, indexing="ij"), axis=-1).reshape(-1, 2)

    def _checked(self, angles: ArrayLike) -> FloatArray:
        array = np.asarray(angles, dtype=np.float64)
        if array.ndim not in (1, 2) or array.shape[-1] != self.joints:
            raise InvalidArrayError(
                f"angles have shape {array.shape}, expected ({self.joints},) or (N, {self.joints})"
            )
        return array
