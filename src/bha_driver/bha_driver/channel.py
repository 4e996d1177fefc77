"""One register of the terminal: where it is, and how its raw words become SI values."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bha_common.settings import check_settings, setting
from bha_driver.errors import TerminalMapError
from bha_driver.mapping import required

FORMATS = ("int16", "uint16")
LARGEST_SET_POINT = 0x7FFF
"""Largest raw set-point: as a signed word the next one is negative, and valves misbehave at it."""


@dataclass(frozen=True)
class Channel:
    """An analog value in one 16-bit register: SI value = scale x raw + offset."""

    register: int = required("Modbus address as it goes over the wire", low=0, high=0xFFFF)
    scale: float = required("SI value of one count [Pa or m]")
    offset: float = setting(0.0, "SI value at raw 0 [Pa or m]", low=-1e9, high=1e9)
    format: str = setting("int16", "How the word is to be read", choices=FORMATS)

    def __post_init__(self) -> None:
        check_settings(self)
        if not 1e-9 <= abs(self.scale) <= 1e6:
            raise TerminalMapError(
                f"scale is {self.scale:g}; one count must be worth 1e-09 to 1e+06 Pa or m"
            )

    def value(self, word: int) -> float:
        """Give the SI value of a word as it came over the wire (0 to 65535)."""
        raw = word - 0x10000 if self.format == "int16" and word > 0x7FFF else word
        return self.scale * raw + self.offset

    def word(self, value: float) -> int:
        """Give the word whose value is nearest; beyond the range of words, the end of it."""
        low, high = (-0x8000, 0x7FFF) if self.format == "int16" else (0, 0xFFFF)
        raw = min(max(round((value - self.offset) / self.scale), low), high)
        return raw & 0xFFFF

    def set_point_range(self, highest: float) -> tuple[int, int]:
        """Tell the raw set-points from 0 Pa to `highest` [Pa], neither end exceeded.

        Raises
        ------
        TerminalMapError
            When such a set-point would be negative, or too large for a signed word.
        """
        if self.scale < 0.0:
            raise TerminalMapError("scale must be above 0: a larger set-point is more pressure")
        # Slack against rounding: 1.3e5 / 6.5 must be 20000 and not 19999.
        low = math.ceil(-self.offset / self.scale - 1e-9)
        high = math.floor((highest - self.offset) / self.scale + 1e-9)
        if low < 0:
            raise TerminalMapError(
                f"offset is {self.offset:g}: 0 Pa would be the raw set-point {low}, and a negative "
                "set-point makes a valve misbehave; it must be 0 or less"
            )
        if high > LARGEST_SET_POINT:
            raise TerminalMapError(
                f"scale is {self.scale:g}: {highest:g} Pa would be the raw set-point {high}; "
                f"at most {LARGEST_SET_POINT} is possible"
            )
        if high <= low:
            raise TerminalMapError(
                f"scale is {self.scale:g}: the raw set-points from 0 to {highest:g} Pa are "
                f"{low} to {high}; nothing could be set"
            )
        return low, high
