"""Steps of all pressures together, up and down, and the lengths that follow them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows

Array = NDArray[np.float64]

_LEVELS = (0.35, 0.65)  # shares of the highest pressure: the middle of the range, as in use
_REST = 2.0  # [s] from one step to the next


class PressureSteps:
    """Asks for pressures, is told lengths, until the steps are done.

    Parameters
    ----------
    count : Number of steps.
    max_pressure : Upper end of the range of pressures [Pa].
    start : Pressures that are applied now [Pa], shape (9,).
    rate : Fastest change of a pressure on the way to where the steps begin [Pa/s].
    period : Time between two updates [s].
    """

    def __init__(
        self, count: int, *, max_pressure: float, start: Array, rate: float, period: float
    ) -> None:
        self._count = count
        self._levels = [np.full(bellows.COUNT, share * max_pressure) for share in _LEVELS]
        self._output = start
        self._way = rate * period
        self._rest = round(_REST / period)
        self._seen: list[Array] = []

    @property
    def done(self) -> bool:
        """Whether all steps are over."""
        return len(self._seen) >= self._rest * (self._count + 1) or self._count == 0

    def seen(self) -> tuple[Array, Array]:
        """Lengths measured so far [m] and pressures asked for then [Pa], shape (k, n, 9).

        Of the k times that pressures were held; the first is before the first step.
        """
        count = len(self._seen) // self._rest
        lengths = np.array(self._seen[: count * self._rest])
        levels = np.array([self._levels[k % 2] for k in range(count)])
        shape = (count, self._rest, bellows.COUNT)
        return lengths.reshape(shape), np.broadcast_to(
            levels.reshape(count, 1, bellows.COUNT), shape
        )

    def update(self, lengths: Array) -> Array:
        """Take lengths [m], shape (9,), and tell the pressures for the next period [Pa], (9,)."""
        start = self._levels[0]
        if not self._seen and not np.array_equal(self._output, start):
            away = start - self._output
            self._output = self._output + np.clip(away, -self._way, self._way)
            return self._output
        if not self.done:
            self._output = self._levels[len(self._seen) // self._rest % 2]
            self._seen.append(lengths)
        return self._output
