"""The fast way and rclpy's way over the same bytes: whatever one writes, the other reads."""

import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

pytest.importorskip("rclpy", reason="needs ROS 2")
pytest.importorskip("bha_interfaces.msg", reason="needs the workspace's interfaces")

from bha_interfaces.msg import Pressures
from geometry_msgs.msg import PointStamped, PoseStamped
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState

from bha_common import ros_wire
from bha_common.ros_messages import (
    MessageError,
    lengths_message,
    point_message,
    pressures_message,
    tip_message,
)
from bha_common.ros_wire import decoder, encode_lengths, encode_pressures

NINE = hnp.arrays(np.float64, 9, elements=st.floats(-1e9, 1e9))
TIMES = st.integers(0, 2**31 * 10**9 - 1)
SOME = np.linspace(0.11, 0.29, 9)
TYPES = {
    "lengths": (JointState, lengths_message, encode_lengths),
    "pressures": (Pressures, pressures_message, encode_pressures),
}
STREAM = pytest.mark.parametrize("stream", TYPES)


def serialized(message: Any) -> bytes:
    return bytes(serialize_message(message))


@pytest.fixture
def without_rclpy(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> None:
        raise AssertionError("the usual layout must be read without rclpy")

    monkeypatch.setattr(ros_wire, "deserialize_message", refuse)


@settings(max_examples=40, deadline=None)
@given(values=NINE, time=TIMES)
@STREAM
def test_rclpy_reads_what_is_encoded(stream: str, values: NDArray[np.float64], time: int) -> None:
    message_type, make, encode = TYPES[stream]
    assert deserialize_message(encode(time, values), message_type) == make(time, values)


@settings(max_examples=40, deadline=None)
@given(values=NINE, time=TIMES)
@STREAM
def test_what_rclpy_writes_is_decoded(stream: str, values: NDArray[np.float64], time: int) -> None:
    message_type, make, _ = TYPES[stream]
    stamp, decoded = decoder(message_type)(serialized(make(time, values)))
    assert (stamp, decoded.tobytes()) == (time, values.tobytes())


@pytest.mark.usefixtures("without_rclpy")
@STREAM
def test_the_usual_layout_needs_no_rclpy(stream: str) -> None:
    message_type, make, encode = TYPES[stream]
    for data in (encode(7, SOME), serialized(make(7, SOME))):
        stamp, decoded = decoder(message_type)(data)
        assert stamp == 7
        np.testing.assert_array_equal(decoded, SOME)


@STREAM
def test_padding_may_hold_anything(stream: str) -> None:
    message_type, _, encode = TYPES[stream]
    data = bytearray(encode(7, SOME))
    frame = data.index(b"bha_base") + len(b"bha_base\0")
    data[frame : frame + 3] = b"xyz"  # up to the next multiple of four
    np.testing.assert_array_equal(decoder(message_type)(bytes(data))[1], SOME)


@STREAM
def test_another_order_is_put_right(stream: str) -> None:
    message_type, make, _ = TYPES[stream]
    message = make(7, SOME[::-1].copy())
    message.name = message.name[::-1]
    np.testing.assert_array_equal(decoder(message_type)(serialized(message))[1], SOME)


def test_fields_that_are_not_needed_may_be_there() -> None:
    message = lengths_message(7, SOME)
    message.velocity = [1.0] * 9
    message.effort = [2.0] * 9
    message.header.frame_id = "elsewhere"  # lengths are in no frame
    np.testing.assert_array_equal(decoder(JointState)(serialized(message))[1], SOME)


@pytest.mark.parametrize("byte_order", ["little", "big"])
def test_both_byte_orders(byte_order: str) -> None:
    data = encode_lengths(7 * 10**9 + 5, SOME)
    if byte_order == "big":
        message = _swapped(data)
        assert message[:2] == b"\x00\x00"
    else:
        message = data
    stamp, decoded = decoder(JointState)(message)
    assert stamp == 7 * 10**9 + 5
    np.testing.assert_array_equal(decoded, SOME)


def _swapped(data: bytes) -> bytes:
    """Turn our own message into big-endian CDR."""
    little = ros_wire._LENGTHS._struct
    fields = little.unpack(data)
    return struct.pack(">" + little.format[1:], b"\x00\x00\x00\x00", *fields[1:])


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@STREAM
def test_what_is_not_finite_is_refused_with_its_name(stream: str, bad: float) -> None:
    message_type, make, encode = TYPES[stream]
    values = SOME.copy()
    values[4] = bad
    for data in (encode(7, values), serialized(make(7, values))):
        with pytest.raises(MessageError, match="not finite for bellows_2_2"):
            decoder(message_type)(data)


@STREAM
def test_too_few_values_are_refused(stream: str) -> None:
    message_type, make, _ = TYPES[stream]
    with pytest.raises(MessageError, match="8 values; 9 are needed"):
        decoder(message_type)(serialized(make(7, SOME[:8])))


def test_points_are_read_by_rclpy() -> None:
    point = np.array([0.1, -0.2, 0.7])
    tip = tip_message(7, point, np.array([0.0, 0.0, 0.0, 1.0]))
    for message_type, message in ((PoseStamped, tip), (PointStamped, point_message(7, point))):
        stamp, decoded = decoder(message_type)(serialized(message))
        assert stamp == 7
        np.testing.assert_array_equal(decoded, point)
    with pytest.raises(MessageError, match="frame_id is ''"):
        decoder(PointStamped)(serialized(PointStamped()))
