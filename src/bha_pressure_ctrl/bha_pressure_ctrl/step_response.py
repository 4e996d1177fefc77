"""How pressures follow a step of what is asked for: dead time and lag of valves and hoses.

    y(t) = a (1 - exp(-(t - d) / T)),      t >= d

where y is told by the lengths: the pressures that hold them. So what the bellows themselves do on
their way, creep and friction, is not taken for a lag.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

Array = NDArray[np.float64]

_LONGEST = 1.5  # [s] of the response that is fitted
_STARTS = ((0.05, 0.1), (0.1, 0.3), (0.2, 0.6))
_LOW, _HIGH = (0.0, 0.01), (0.5, 1.0)  # [s] dead time and lag that are believed
_BELIEVED = (
    0.5,
    1.5,
)  # share of a step that is held in the end; else it is not the step that shows


def fit_step_response(before: Array, after: Array, period: float) -> tuple[float, float] | None:
    """Fit dead time and lag [s] to steps of all bellows that went the same way.

    Parameters
    ----------
    before : Pressures held before every step, as shares of it from its start, shape (s, 9).
    after : The same for every period after it, shape (s, n, 9); the first as it is applied.
    period : Time between them [s].

    Returns
    -------
    None when there are no steps, or when they do not show.
    """
    if len(before) == 0:
        return None
    response = (after - before[:, None]).mean(axis=(0, 2))[: round(_LONGEST / period)]
    time = period * np.arange(len(response))

    def shape(numbers: Array) -> Array:
        rise: Array = -np.expm1(-np.maximum(time - numbers[0], 0.0) / numbers[1])
        return rise

    def share(numbers: Array) -> float:
        rise = shape(numbers)
        return float(rise @ response / max(float(rise @ rise), 1e-12))

    def residuals(numbers: Array) -> Array:
        left: Array = share(numbers) * shape(numbers) - response
        return left

    fits = [least_squares(residuals, start, bounds=(_LOW, _HIGH)) for start in _STARTS]
    found = min(fits, key=lambda fit: float(fit.cost)).x
    if not _BELIEVED[0] <= share(found) <= _BELIEVED[1]:
        return None
    return float(found[0]), float(found[1])
