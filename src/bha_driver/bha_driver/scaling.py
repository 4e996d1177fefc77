"""The words of all bellows to SI values and back, at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bha_driver.channel import Channel
from bha_driver.terminal_map import TerminalMap

Array = NDArray[np.float64]
Words = NDArray[np.int64]


class _Inputs:
    """Nine channels of the block that is read."""

    def __init__(self, channels: Sequence[Channel], first: int) -> None:
        self._place = np.array([channel.register - first for channel in channels])
        self._signed = np.array([channel.format == "int16" for channel in channels])
        self._scale = np.array([channel.scale for channel in channels])
        self._offset = np.array([channel.offset for channel in channels])

    def raw(self, block: Words) -> Words:
        words = block[self._place]
        return np.asarray(np.where(self._signed & (words > 0x7FFF), words - 0x10000, words))

    def values(self, raw: Words) -> Array:
        return np.asarray(self._scale * raw + self._offset)


class Scaling:
    """Conversions between the blocks of a terminal and SI units.

    Parameters
    ----------
    terminal : The terminal's map.
    """

    def __init__(self, terminal: TerminalMap) -> None:
        first, _ = terminal.input_block
        self._lengths = _Inputs([item.length for item in terminal.bellows], first)
        self._pressures = _Inputs([item.pressure for item in terminal.bellows], first)
        channels = [item.set_point for item in terminal.bellows]
        first, count = terminal.output_block
        self._place = np.array([channel.register - first for channel in channels])
        self._scale = np.array([channel.scale for channel in channels])
        self._offset = np.array([channel.offset for channel in channels])
        ranges = [channel.set_point_range(terminal.limits.pressure) for channel in channels]
        self._low, self._high = (
            np.array(ends, dtype=np.int64) for ends in zip(*ranges, strict=True)
        )
        self._count = count

    @property
    def vented(self) -> Words:
        """Raw set-points of 0 Pa as a block to write, shape (9,)."""
        block = np.empty(self._count, dtype=np.int64)
        block[self._place] = self._low
        return block

    @property
    def count_worth(self) -> Array:
        """Pressure of one count of each set-point [Pa], shape (9,)."""
        return self._scale.copy()

    def raw_lengths(self, block: Words) -> Words:
        """Raw lengths in the order of the bellows, shape (9,), of the block that was read."""
        return self._lengths.raw(block)

    def lengths(self, block: Words) -> Array:
        """Lengths [m], shape (9,), of the block that was read."""
        return self._lengths.values(self._lengths.raw(block))

    def pressures(self, block: Words) -> Array:
        """Measured pressures [Pa], shape (9,), of the block that was read."""
        return self._pressures.values(self._pressures.raw(block))

    def set_points(self, pressures: Array) -> Words:
        """Give the block of raw set-points nearest to pressures, within the range of each valve.

        Parameters
        ----------
        pressures : Pressures [Pa], shape (9,), finite.

        Returns
        -------
        Words to write, shape (9,): none negative, none beyond the limit.
        """
        raw = np.rint((pressures - self._offset) / self._scale)
        block = np.empty(self._count, dtype=np.int64)
        block[self._place] = np.clip(raw, self._low, self._high).astype(np.int64)
        return block

    def commanded(self, block: Words) -> Array:
        """Pressures [Pa], shape (9,), that a block of raw set-points means."""
        return np.asarray(self._scale * block[self._place] + self._offset)
