"""Which measured lengths can be true: in range, without jumps, and not frozen."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_driver.terminal_map import Limits

Array = NDArray[np.float64]
Words = NDArray[np.int64]


class Plausibility:
    """Judges each reading by those before it.

    A reading is frozen when its raw value has not changed by one count for a while, although the
    set-point of that bellows moved a good deal in that time. A robot at rest is not frozen.

    Parameters
    ----------
    limits : Which lengths, and which changes of them, are believed.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self.forget()

    def forget(self) -> None:
        """Begin anew: the next reading is judged by its range alone."""
        self._time: float | None = None
        self._lengths = np.zeros(bellows.COUNT)
        self._raw = np.zeros(bellows.COUNT, dtype=np.int64)
        self._since = np.zeros(bellows.COUNT)
        self._lowest = np.zeros(bellows.COUNT)
        self._highest = np.zeros(bellows.COUNT)

    def out_of_range(self, lengths: Array) -> str:
        """Name the first length that no bellows can have; empty when there is none."""
        limits = self._limits
        wrong = np.flatnonzero(~((lengths >= limits.shortest) & (lengths <= limits.longest)))
        if not len(wrong):
            return ""
        return (
            f"{bellows.NAMES[wrong[0]]} is {lengths[wrong[0]]:.4f} m long; "
            f"{limits.shortest:g} to {limits.longest:g} m are believed"
        )

    def judge(self, time: float, raw: Words, lengths: Array, pressures: Array) -> tuple[str, str]:
        """Judge a reading.

        Parameters
        ----------
        time : Time of the reading [s].
        raw : Raw lengths, shape (9,).
        lengths : Lengths [m], shape (9,).
        pressures : Set-points that are in force [Pa], shape (9,).

        Returns
        -------
        Which kind of fault there is (``length out of range``, ``length jumped``, ``length
        frozen``) and a sentence that names the bellows; both empty when all is well.
        """
        reason = self.out_of_range(lengths)
        if reason:
            self._time = None  # what follows a bad reading cannot be judged by it
            return "length out of range", reason
        if self._time is None:
            self._begin(time, raw, lengths, pressures)
            return "", ""
        limits = self._limits
        change = np.abs(lengths - self._lengths)
        believed = limits.length_step + limits.length_rate * (time - self._time)
        self._time, self._lengths = time, lengths
        same = raw == self._raw
        self._raw = raw
        self._since = np.where(same, self._since, time)
        self._lowest = np.where(same, np.minimum(self._lowest, pressures), pressures)
        self._highest = np.where(same, np.maximum(self._highest, pressures), pressures)
        if (change > believed).any():
            worst = int(np.argmax(change))
            return "length jumped", (
                f"{bellows.NAMES[worst]} changed by {change[worst]:.4f} m between two readings; "
                f"at most {believed:.4f} m is believed"
            )
        moved = self._highest - self._lowest
        frozen = (time - self._since >= limits.frozen_time) & (moved >= limits.frozen_pressure)
        if frozen.any():
            first = int(np.argmax(frozen))
            return "length frozen", (
                f"{bellows.NAMES[first]} has kept to the raw value {raw[first]} for "
                f"{time - self._since[first]:.2f} s, while its set-point moved by "
                f"{moved[first]:.0f} Pa"
            )
        return "", ""

    def _begin(self, time: float, raw: Words, lengths: Array, pressures: Array) -> None:
        self._time, self._lengths, self._raw = time, lengths, raw
        self._since = np.full(bellows.COUNT, time)
        self._lowest, self._highest = pressures.copy(), pressures.copy()
