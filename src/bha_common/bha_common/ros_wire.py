"""The streams of the control chain as they lie on the wire: bytes to arrays and back.

rclpy builds a Python object a field and a list of nine names for every message: 60 us for each
hop of lockstep, half of what a hop costs. But lengths and pressures of our own nodes all have one
layout, which `struct` reads and writes in 3 us. A message with any other layout, such as other
names or another order, is read by rclpy; so both ways understand the same messages.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from bha_interfaces.msg import Pressures
from geometry_msgs.msg import PointStamped, PoseStamped
from numpy.typing import NDArray
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import JointState

from bha_common import bellows
from bha_common.ros_messages import (
    finite,
    lengths_from,
    nanoseconds,
    pressures_from,
    target_from,
    tip_from,
)

Array = NDArray[np.float64]

_SECOND = 1_000_000_000
_CDR_LITTLE_ENDIAN = b"\x00\x01\x00\x00"


class _Layout:
    """The usual layout of a message with a header, nine names and nine values.

    That is plain CDR (OMG DDS-RTPS 2.5, 10.5; OMG CORBA 3.4, part 2, 9.3): a header of four bytes,
    then each number aligned to its own size, strings and sequences after their count.

    Parameters
    ----------
    empty_sequences : How many sequences follow the values; the usual message leaves them empty.
    """

    def __init__(self, empty_sequences: int) -> None:
        layout = "<4siI"  # encapsulation, stamp
        fixed: list[int | bytes] = []

        def add_string(text: str) -> None:
            nonlocal layout
            data = text.encode() + b"\0"
            layout += f"I{len(data)}s{-len(data) % 4}x"
            fixed.extend((len(data), data))

        def add_count() -> None:
            nonlocal layout
            layout += "I"
            fixed.append(bellows.COUNT)

        add_string(bellows.BASE_FRAME)
        add_count()
        for name in bellows.NAMES:
            add_string(name)
        add_count()
        padding = (4 - struct.calcsize(layout)) % 8  # values are aligned behind the encapsulation
        self._struct = struct.Struct(f"{layout}{padding}x{bellows.COUNT}d{empty_sequences}I")
        self._fixed = tuple(fixed)
        self._tail = (0,) * empty_sequences
        self._values = slice(3 + len(fixed), 3 + len(fixed) + bellows.COUNT)

    def pack(self, time: int, values: Array) -> bytes:
        return self._struct.pack(
            _CDR_LITTLE_ENDIAN,
            time // _SECOND,
            time % _SECOND,
            *self._fixed,
            *values.tolist(),
            *self._tail,
        )

    def unpack(self, data: bytes) -> tuple[int, Array] | None:
        """Give stamp [ns] and values, shape (9,), or None when the layout is another one."""
        if len(data) < self._struct.size:
            return None
        fields = self._struct.unpack_from(data)
        if fields[0] != _CDR_LITTLE_ENDIAN or fields[3 : self._values.start] != self._fixed:
            return None
        if fields[self._values.stop :] != self._tail:
            return None
        return fields[1] * _SECOND + fields[2], np.array(fields[self._values])


_LENGTHS, _PRESSURES = _Layout(empty_sequences=2), _Layout(empty_sequences=0)


def encode_lengths(time: int, lengths: Array) -> bytes:
    """Serialise a JointState of lengths [m], shape (9,), stamped `time` [ns]."""
    return _LENGTHS.pack(time, lengths)


def encode_pressures(time: int, pressures: Array) -> bytes:
    """Serialise Pressures [Pa], shape (9,), stamped `time` [ns]."""
    return _PRESSURES.pack(time, pressures)


def decoder(message_type: Any) -> Callable[[bytes], tuple[int, Array]]:
    """Give the function that reads serialised messages of one type.

    Parameters
    ----------
    message_type : JointState (lengths), Pressures, PoseStamped (tip) or PointStamped (target).

    Returns
    -------
    Function from the bytes to the stamp [ns] and the values, shape (9,) or (3,); it raises
    MessageError when the message cannot be used, see `ros_messages`.
    """
    layout, field = {JointState: (_LENGTHS, "position"), Pressures: (_PRESSURES, "pressure")}.get(
        message_type, (None, "")
    )
    read = {
        JointState: lengths_from,
        Pressures: pressures_from,
        PoseStamped: tip_from,
        PointStamped: target_from,
    }[message_type]

    def decode(data: bytes) -> tuple[int, Array]:
        usual = None if layout is None else layout.unpack(data)
        if usual is not None:
            return usual[0], finite(usual[1], field)
        message = deserialize_message(data, message_type)
        return nanoseconds(message.header.stamp), read(message)

    return decode
