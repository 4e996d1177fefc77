"""What can be wrong with a message on a topic, for the tests of the nodes that must drop it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from bha_common import bellows
from bha_common.ros_messages import (
    lengths_message,
    point_message,
    pressures_message,
    stamp_message,
    tip_message,
)
from running_graph import SECOND


def _values(message: Any) -> Any:
    return message.pressure if hasattr(message, "pressure") else message.position


def _first(value: float) -> Callable[[Any, int], None]:
    def spoil(message: Any, _: int) -> None:
        _values(message)[0] = value

    return spoil


def _eight_values(message: Any, _: int) -> None:
    _values(message).pop()
    message.name = message.name[:-1]


def _ten_values(message: Any, _: int) -> None:
    _values(message).append(0.2)
    message.name = [*message.name, "bellows_4_1"]


def _no_names(message: Any, _: int) -> None:
    message.name = []


def _unknown_name(message: Any, _: int) -> None:
    message.name = [*message.name[:-1], "wrist_1"]


def _doubled_name(message: Any, _: int) -> None:
    message.name = [*message.name[:-1], message.name[0]]


def _stamped(age: float | None) -> Callable[[Any, int], None]:
    def spoil(message: Any, now: int) -> None:
        message.header.stamp = stamp_message(0 if age is None else now - round(age * SECOND))

    return spoil


def _frame(name: str) -> Callable[[Any, int], None]:
    def spoil(message: Any, _: int) -> None:
        message.header.frame_id = name

    return spoil


def _coordinate(value: float) -> Callable[[Any, int], None]:
    def spoil(message: Any, _: int) -> None:
        point = message.point if hasattr(message, "point") else message.pose.position
        point.y = value

    return spoil


OF_NINE = {
    "NaN": (_first(math.nan), "not finite for bellows_1_1"),
    "inf": (_first(-math.inf), "not finite for bellows_1_1"),
    "eight values": (_eight_values, "8 values; 9 are needed"),
    "ten values": (_ten_values, "10 values; 9 are needed"),
    "no names": (_no_names, "0 names"),
    "unknown name": (_unknown_name, "unknown ['wrist_1'], missing ['bellows_3_3']"),
    "doubled name": (_doubled_name, "unknown none, missing ['bellows_3_3']"),
}
OF_A_POINT = {
    "NaN": (_coordinate(math.nan), "not finite"),
    "inf": (_coordinate(math.inf), "not finite"),
    "wrong frame": (_frame("map"), "frame_id is 'map'; it must be 'bha_base'"),
    "no frame": (_frame(""), "frame_id is ''; it must be 'bha_base'"),
}
STAMPS = {
    "no stamp": (_stamped(None), "no stamp"),
    "too old": (_stamped(5.0), "s old; at most"),
    "future": (_stamped(-500.0), "s old; at most"),
}
STREAM_STAMPS = {
    "no stamp": (_stamped(None), "no stamp"),
    "too old": (_stamped(5.0), "not newer"),
    "future": (_stamped(-500.0), "leaps ahead"),
}
TIP_STAMPS = {
    "no stamp": (_stamped(None), "no stamp"),
    "too old": (_stamped(5.0), "stamp"),
    "future": (_stamped(-500.0), "stamp"),
}

BAD_LENGTHS = np.full(bellows.COUNT, 0.30)
BAD_PRESSURES = np.full(bellows.COUNT, bellows.MAX_PRESSURE)
BAD_POINT = np.array([0.3, 0.3, 0.6])

TOPICS: dict[str, tuple[Callable[[int], Any], dict[str, Any], tuple[str, ...]]] = {
    "pressure_command": (
        lambda now: pressures_message(now, BAD_PRESSURES),
        {**OF_NINE, **STAMPS},
        ("simulator",),
    ),
    "length_command": (
        lambda now: lengths_message(now, BAD_LENGTHS),
        {**OF_NINE, **STAMPS},
        ("pressure_ctrl",),
    ),
    "lengths": (
        lambda now: lengths_message(now, BAD_LENGTHS),
        {**OF_NINE, **STREAM_STAMPS, "millimetres": (_first(300.0), "is it in metres?")},
        ("pressure_ctrl", "learner"),
    ),
    "tip": (
        lambda now: tip_message(now, BAD_POINT, np.array([0.0, 0.0, 0.0, 1.0])),
        {**OF_A_POINT, **TIP_STAMPS, "millimetres": (_coordinate(300.0), "is it in metres,")},
        ("learner", "cartesian_feedback"),
    ),
    "target": (lambda now: point_message(now, BAD_POINT), {**OF_A_POINT, **STAMPS}, ("learner",)),
}
"""A message that would move the robot, what can be wrong with it, and who must drop it."""
