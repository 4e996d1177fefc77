"""Messages to arrays and back; a message that cannot be used is refused with the reason."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from bha_interfaces.msg import Pressures
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PointStamped, PoseStamped
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

from bha_common import bellows

Array = NDArray[np.float64]

_NAMES = list(bellows.NAMES)
_SECOND = 1_000_000_000


class MessageError(ValueError):
    """A message that must be dropped; the text says why."""


def nanoseconds(stamp: Time) -> int:
    """Give a stamp as whole nanoseconds."""
    return int(stamp.sec) * _SECOND + int(stamp.nanosec)


def stamp_message(time: int) -> Time:
    """Give a time [ns] as a stamp."""
    return Time(sec=time // _SECOND, nanosec=time % _SECOND)


def lengths_message(time: int, lengths: Array) -> JointState:
    """Make a message of lengths [m], shape (9,), stamped `time` [ns]."""
    return JointState(header=_header(time), name=_NAMES.copy(), position=lengths.tolist())


def pressures_message(time: int, pressures: Array) -> Pressures:
    """Make a message of pressures [Pa], shape (9,), stamped `time` [ns]."""
    return Pressures(header=_header(time), name=_NAMES.copy(), pressure=pressures.tolist())


def tip_message(time: int, tip: Array, quaternion: Array) -> PoseStamped:
    """Make a pose of the tip: position [m], shape (3,), and quaternion x, y, z, w, shape (4,)."""
    message = PoseStamped(header=_header(time))
    position, orientation = message.pose.position, message.pose.orientation
    position.x, position.y, position.z = tip.tolist()
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion.tolist()
    return message


def point_message(time: int, point: Array) -> PointStamped:
    """Make a point [m], shape (3,), stamped `time` [ns]."""
    message = PointStamped(header=_header(time))
    message.point.x, message.point.y, message.point.z = point.tolist()
    return message


def plain_point(position: Array | None) -> Point:
    """Make a point of up to three coordinates [m]; those that are not there are NaN."""
    known = [] if position is None else position.tolist()
    x, y, z = known + [math.nan] * (3 - len(known))
    return Point(x=x, y=y, z=z)


def lengths_from(message: JointState) -> Array:
    """Read lengths [m], shape (9,), in the order of `bellows.NAMES`.

    Raises
    ------
    MessageError
        When there are not exactly nine finite lengths of the nine bellows.
    """
    return _in_order(message.name, message.position, "position")


def pressures_from(message: Pressures) -> Array:
    """Read pressures [Pa], shape (9,), in the order of `bellows.NAMES`.

    Raises
    ------
    MessageError
        When there are not exactly nine finite pressures of the nine bellows.
    """
    return _in_order(message.name, message.pressure, "pressure")


def tip_from(message: PoseStamped) -> Array:
    """Read the position of the tip [m], shape (3,), in frame `bha_base`.

    Raises
    ------
    MessageError
        When it is in another frame, not finite, or where no tip can be.
    """
    tip = _point(message.header, message.pose.position, frame_needed=True)
    distance = math.hypot(*tip.tolist())
    if distance > bellows.MAX_REACH:
        raise MessageError(
            f"the tip is {distance:.3g} m from the base; at most {bellows.MAX_REACH:g} m is "
            "believed (is it in metres, and in the right frame?)"
        )
    return tip


def target_from(message: PointStamped) -> Array:
    """Read a target [m], shape (3,), in frame `bha_base`.

    Raises
    ------
    MessageError
        When it is in another frame, or not finite.
    """
    return _point(message.header, message.point, frame_needed=True)


def goal_from(message: PointStamped) -> Array:
    """Read a goal [m], shape (3,), in frame `bha_base`, which an empty frame means too.

    Raises
    ------
    MessageError
        When it is in another frame, or not finite.
    """
    return _point(message.header, message.point, frame_needed=False)


def finite(values: Array, field: str) -> Array:
    """Give back values of the nine bellows, shape (9,), when all are finite.

    Raises
    ------
    MessageError
        When one is not; `field` is what it is called in the message.
    """
    # A sum is finite only if its terms are, and costs a tenth of isfinite().all(); Python's own
    # overflows without a warning.
    if not math.isfinite(sum(values.tolist())):
        bad = [name for name, value in zip(_NAMES, values, strict=True) if not np.isfinite(value)]
        what = f"not finite for {', '.join(bad)}" if bad else "absurdly large"
        raise MessageError(f"{field} is {what}")
    return values


def check_measured_lengths(lengths: Array) -> None:
    """Refuse measured lengths [m], shape (9,), that no bellows can have.

    Raises
    ------
    MessageError
        Naming the bellows and the lengths that are believed.
    """
    for name, length in zip(_NAMES, lengths.tolist(), strict=True):
        if not bellows.MIN_LENGTH <= length <= bellows.MAX_LENGTH:
            raise MessageError(
                f"{name} is {length:.4g} m long; {bellows.MIN_LENGTH:g} to "
                f"{bellows.MAX_LENGTH:g} m are believed (is it in metres?)"
            )


def _header(time: int) -> Header:
    return Header(stamp=stamp_message(time), frame_id=bellows.BASE_FRAME)


def _in_order(names: list[str], values: Any, field: str) -> Array:
    array = np.array(values, dtype=np.float64)
    if array.shape != (bellows.COUNT,):
        raise MessageError(f"{field} has {array.size} values; {bellows.COUNT} are needed")
    if names != _NAMES:
        if sorted(names) != sorted(_NAMES):
            wrong = sorted(set(names) - set(_NAMES))
            missing = sorted(set(_NAMES) - set(names))
            raise MessageError(
                "name must hold each of the nine bellows once: "
                f"unknown {wrong or 'none'}, missing {missing or 'none'}, {len(names)} names"
            )
        array = array[[names.index(name) for name in _NAMES]]
    return finite(array, field)


def _point(header: Header, point: Point, *, frame_needed: bool) -> Array:
    allowed = (bellows.BASE_FRAME,) if frame_needed else (bellows.BASE_FRAME, "")
    if header.frame_id not in allowed:
        raise MessageError(f"frame_id is {header.frame_id!r}; it must be {bellows.BASE_FRAME!r}")
    array = np.array([point.x, point.y, point.z])
    if not np.all(np.isfinite(array)):
        raise MessageError(f"the point ({point.x}, {point.y}, {point.z}) is not finite")
    return array
