"""Ends of a range that a value comes ever nearer to and never passes, still rising.

In the inner range nothing changes. Within `MARGIN` of an end, and beyond, the value x (0 and 1
being the ends) becomes

    m^2 / (2 m - x)   for x < m,      and mirrored at the upper end

which goes on with the same slope at x = m and tends to 0. It falls off like 1/x and not like an
exponential, so that a double still tells it rising far beyond the end.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MARGIN = 0.02
"""Share of the range at each end in which values are bent."""


def bend(values: Array, top: float) -> Array:
    """Bring values into the open range from 0 to `top`, strictly rising with them.

    Parameters
    ----------
    values : Any values, any shape.
    top : Upper end of the range, in their unit.
    """
    x = values / top
    lower = MARGIN**2 / (2.0 * MARGIN - np.minimum(x, MARGIN))
    upper = 1.0 - MARGIN**2 / (2.0 * MARGIN - np.minimum(1.0 - x, MARGIN))
    bent: Array = top * np.where(x < MARGIN, lower, np.where(x > 1.0 - MARGIN, upper, x))
    return bent


def bend_slopes(values: Array, top: float) -> Array:
    """Return the derivative of `bend`, of the same shape; above 0."""
    outside = MARGIN - np.minimum(np.minimum(values, top - values) / top, MARGIN)
    slopes: Array = (MARGIN / (MARGIN + outside)) ** 2
    return slopes
