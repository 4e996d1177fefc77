"""Zero and span of a potentiometer: from two lengths that were measured by hand to the map."""

from __future__ import annotations

import math
from typing import Any

import yaml

from bha_common.bellows import NAMES
from bha_driver.errors import TerminalMapError
from bha_driver.terminal_file import parse_terminal

LEAST_SPAN = 0.03
"""Least distance of the two lengths [m]: with less, an error of 1 mm is one of 3 % in the scale."""
_LEAST_COUNTS = 50


def scale_and_offset(raw: tuple[float, float], lengths: tuple[float, float]) -> tuple[float, float]:
    """Give the line through two points: length = scale x raw + offset.

    Parameters
    ----------
    raw : Mean raw values at the two points [counts].
    lengths : Lengths that were measured there [m].

    Raises
    ------
    ValueError
        When the points are too near to one another.
    """
    counts, span = raw[1] - raw[0], lengths[1] - lengths[0]
    if not (math.isfinite(counts) and math.isfinite(span)):
        raise ValueError("lengths and raw values must be numbers")
    if abs(span) < LEAST_SPAN:
        raise ValueError(
            f"the two lengths are {abs(span) * 1e3:.0f} mm apart; "
            f"at least {LEAST_SPAN * 1e3:.0f} mm are needed"
        )
    if abs(counts) < _LEAST_COUNTS:
        raise ValueError(
            f"the raw value changed by {abs(counts):.0f} counts only; is this the right register, "
            "and is the potentiometer connected?"
        )
    scale = span / counts
    return scale, lengths[0] - scale * raw[0]


def with_calibration(text: str, bellows: str, scale: float, offset: float) -> str:
    """Write scale and offset of a potentiometer into the text of a terminal map.

    Nothing else of the text changes, comments least of all.

    Parameters
    ----------
    text : The terminal map.
    bellows : Which bellows, such as ``bellows_1_1``.
    scale, offset : Length of a count, and length at raw 0 [m].

    Raises
    ------
    TerminalMapError
        When the text cannot be changed in that way, or would be wrong then.
    """
    if bellows not in NAMES:
        raise TerminalMapError(f"bellows.{bellows} is unknown; valid are {', '.join(NAMES)}")
    node: Any = yaml.compose(text)
    for key in ("bellows", bellows, "length"):
        node = _child(node, key)
    places = {name: _child(node, name) for name in ("scale", "offset")}
    values = {"scale": f"{scale:.6e}", "offset": f"{offset:.6f}"}
    if places["scale"] is None:
        raise TerminalMapError(f"bellows.{bellows}.length.scale is missing")
    changes = [(places["scale"], values["scale"])]
    if places["offset"] is not None:
        changes.append((places["offset"], values["offset"]))
    elif node.flow_style:
        changes[0] = (places["scale"], f"{values['scale']}, offset: {values['offset']}")
    else:
        indent = " " * node.start_mark.column
        changes[0] = (places["scale"], f"{values['scale']}\n{indent}offset: {values['offset']}")
    for place, value in sorted(changes, key=lambda item: -item[0].start_mark.index):
        text = text[: place.start_mark.index] + value + text[place.end_mark.index :]
    channel = parse_terminal(text).bellows[NAMES.index(bellows)].length
    if not (
        math.isclose(channel.scale, scale, rel_tol=1e-5)
        and math.isclose(channel.offset, offset, abs_tol=1e-5)
    ):
        raise TerminalMapError(f"bellows.{bellows}.length could not be changed: edit it by hand")
    return text


def _child(node: Any, key: str) -> Any:
    if node is None or not isinstance(node, yaml.MappingNode):
        return None
    return next((value for name, value in node.value if name.value == key), None)
