"""The tip of a `PlanarArm` in machine code, as `CompiledGoalBabbler` takes it."""

import math

import numba

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.compiled_babbler import Forward
from bha_goal_babbling.compiled_kernels import FORWARD_SIGNATURE


def planar_arm_forward(length: float = 1.0) -> Forward:
    """Return the compiled kinematics of a planar arm with any number of equal links.

    Parameters
    ----------
    length : float
        Length of the whole arm [m].

    Returns
    -------
    Function of joint angles [rad], shape (m,), that fills the tip [m], shape (2,).
    """

    def forward(angles: FloatArray, tip: FloatArray) -> None:
        heading, x, y = 0.0, 0.0, 0.0
        for angle in angles:
            heading += angle
            x += math.cos(heading)
            y += math.sin(heading)
        tip[0] = x * length / len(angles)
        tip[1] = y * length / len(angles)

    compiled: Forward = numba.cfunc(FORWARD_SIGNATURE, cache=True)(forward)
    return compiled
