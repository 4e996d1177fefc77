"""Messages to arrays and back, and every message that must be refused."""

import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from numpy.typing import NDArray

pytest.importorskip("rclpy", reason="needs ROS 2")
pytest.importorskip("bha_interfaces.msg", reason="needs the workspace's interfaces")

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PointStamped, PoseStamped

from bha_common import bellows
from bha_common.ros_messages import (
    MessageError,
    check_measured_lengths,
    goal_from,
    lengths_from,
    lengths_message,
    nanoseconds,
    point_message,
    pressures_from,
    pressures_message,
    stamp_message,
    target_from,
    tip_from,
    tip_message,
)

NUMBERS = st.floats(-1e9, 1e9)
NINE = hnp.arrays(np.float64, 9, elements=NUMBERS)
THREE = hnp.arrays(np.float64, 3, elements=NUMBERS)
TIMES = st.integers(0, 2**31 * 10**9 - 1)
SOME = np.linspace(0.11, 0.29, 9)
STREAMS = {
    "lengths": (lengths_message, lengths_from, "position"),
    "pressures": (pressures_message, pressures_from, "pressure"),
}
STREAM = pytest.mark.parametrize("stream", STREAMS)


def quaternion() -> NDArray[np.float64]:
    return np.array([0.0, 0.0, 0.6, 0.8])


class TestStamps:
    @settings(max_examples=40, deadline=None)
    @given(TIMES)
    def test_come_back(self, time: int) -> None:
        stamp = stamp_message(time)
        assert nanoseconds(stamp) == time
        assert 0 <= stamp.nanosec < 10**9

    def test_none_is_zero(self) -> None:
        assert nanoseconds(Time()) == 0

    def test_before_the_epoch(self) -> None:
        assert nanoseconds(Time(sec=-1, nanosec=5)) == -(10**9) + 5


class TestPlausibleReadings:
    @pytest.mark.parametrize("length", [0.0, 0.0999, 0.4001, 50.0, 210.0, -0.2])
    def test_lengths_that_no_bellows_has(self, length: float) -> None:
        check_measured_lengths(SOME)
        wrong = SOME.copy()
        wrong[3] = length
        with pytest.raises(MessageError, match=r"bellows_2_1 is .* m long; 0.1 to 0.4 m"):
            check_measured_lengths(wrong)

    def test_a_tip_in_millimetres(self) -> None:
        far = tip_message(1, np.array([120.0, 30.0, 800.0]), quaternion())
        with pytest.raises(MessageError, match=r"is 810 m from the base; at most 2 m .* metres"):
            tip_from(far)


class TestRoundTrips:
    @settings(max_examples=40, deadline=None)
    @given(values=NINE, time=TIMES)
    @STREAM
    def test_nine_numbers(self, stream: str, values: NDArray[np.float64], time: int) -> None:
        make, read, _ = STREAMS[stream]
        message = make(time, values)
        assert read(message).tobytes() == values.tobytes()
        assert nanoseconds(message.header.stamp) == time
        assert list(message.name) == list(bellows.NAMES)
        assert message.header.frame_id == "bha_base"

    @settings(max_examples=40, deadline=None)
    @given(tip=THREE, time=TIMES)
    def test_tip(self, tip: NDArray[np.float64], time: int) -> None:
        tip *= 1.0 / (1.0 + np.linalg.norm(tip))  # where a tip can be
        message = tip_message(time, tip, quaternion())
        assert tip_from(message).tobytes() == tip.tobytes()
        assert nanoseconds(message.header.stamp) == time
        turned = message.pose.orientation
        assert [turned.x, turned.y, turned.z, turned.w] == quaternion().tolist()

    @settings(max_examples=40, deadline=None)
    @given(point=THREE, time=TIMES)
    def test_point(self, point: NDArray[np.float64], time: int) -> None:
        message = point_message(time, point)
        assert target_from(message).tobytes() == point.tobytes()
        assert nanoseconds(message.header.stamp) == time

    def test_what_was_made_does_not_change_with_the_next(self) -> None:
        """A list of names that all messages shared could be spoiled by one who sorts it."""
        first = lengths_message(1, SOME)
        first.name.reverse()
        assert list(lengths_message(2, SOME).name) == list(bellows.NAMES)


class TestNames:
    @settings(max_examples=40, deadline=None)
    @given(values=NINE, order=st.permutations(range(9)))
    @STREAM
    def test_any_order(self, stream: str, values: NDArray[np.float64], order: list[int]) -> None:
        """Another driver may sort its bellows as it likes."""
        make, read, field = STREAMS[stream]
        message = make(1, values[order])
        message.name = [bellows.NAMES[k] for k in order]
        assert len(getattr(message, field)) == 9
        np.testing.assert_array_equal(read(message), values)

    @settings(max_examples=40, deadline=None)
    @given(which=st.integers(0, 8), name=st.text(max_size=12))
    @STREAM
    def test_a_wrong_one(self, stream: str, which: int, name: str) -> None:
        """Unknown, empty, doubled."""
        make, read, _ = STREAMS[stream]
        message = make(1, SOME)
        names = list(bellows.NAMES)
        if names[which] == name:
            return
        names[which] = name
        message.name = names
        with pytest.raises(MessageError, match=f"missing .*{bellows.NAMES[which]}"):
            read(message)

    @STREAM
    def test_doubled(self, stream: str) -> None:
        make, read, _ = STREAMS[stream]
        message = make(1, SOME)
        message.name = ["bellows_1_1", "bellows_1_1", *bellows.NAMES[2:]]
        with pytest.raises(MessageError, match=r"unknown none, missing \['bellows_1_2'\]"):
            read(message)

    @pytest.mark.parametrize("names", [[], list(bellows.NAMES[:8]), [*bellows.NAMES, "gripper"]])
    @STREAM
    def test_wrong_count(self, stream: str, names: list[str]) -> None:
        make, read, _ = STREAMS[stream]
        message = make(1, SOME)
        message.name = names
        with pytest.raises(
            MessageError, match=f"each of the nine bellows once.*{len(names)} names"
        ):
            read(message)


class TestNumbers:
    @settings(max_examples=40, deadline=None)
    @given(count=st.integers(0, 20).filter(lambda count: count != 9))
    @STREAM
    def test_wrong_count(self, stream: str, count: int) -> None:
        make, read, field = STREAMS[stream]
        message = make(1, np.full(count, 0.2))
        with pytest.raises(MessageError, match=f"{field} has {count} values; 9 are needed"):
            read(message)

    @settings(max_examples=40, deadline=None)
    @given(
        values=hnp.arrays(
            np.float64,
            9,
            elements=st.sampled_from([0.2, np.nan, np.inf, -np.inf]),
        ).filter(lambda values: not np.isfinite(values).all())
    )
    @STREAM
    def test_not_finite(self, stream: str, values: NDArray[np.float64]) -> None:
        """Also where plus and minus infinity would cancel; every bad one is named, no good one."""
        make, read, field = STREAMS[stream]
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(MessageError, match=f"{field} is not finite") as caught:
                read(make(1, values))
        for name, value in zip(bellows.NAMES, values, strict=True):
            assert (name in str(caught.value)) == (not np.isfinite(value))

    @STREAM
    def test_so_large_that_their_sum_is_none(self, stream: str) -> None:
        """Refused as well, and not as numbers that are none of nobody."""
        make, read, field = STREAMS[stream]
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with pytest.raises(MessageError, match=f"{field} is absurdly large"):
                read(make(1, np.full(9, 1.7e308)))

    @STREAM
    def test_refused_whole(self, stream: str) -> None:
        """Names permuted and one number bad: the right bellows is named."""
        make, read, _ = STREAMS[stream]
        values = SOME.copy()
        values[0] = np.nan
        message = make(1, values)
        message.name = list(reversed(bellows.NAMES))
        with pytest.raises(MessageError, match=r"not finite for bellows_3_3$"):
            read(message)


class TestPoints:
    @pytest.mark.parametrize("frame", ["map", "world", "BHA_BASE", "/bha_base", " "])
    def test_another_frame(self, frame: str) -> None:
        tip, goal = tip_message(1, SOME[:3], quaternion()), point_message(1, SOME[:3])
        tip.header.frame_id = goal.header.frame_id = frame
        for read in (lambda: tip_from(tip), lambda: goal_from(goal)):
            with pytest.raises(MessageError, match="it must be 'bha_base'"):
                read()

    def test_no_frame(self) -> None:
        """A goal typed by hand may leave it out; a stream may not."""
        goal = PointStamped()
        np.testing.assert_array_equal(goal_from(goal), np.zeros(3))
        with pytest.raises(MessageError, match="frame_id is ''"):
            target_from(goal)
        with pytest.raises(MessageError, match="frame_id is ''"):
            tip_from(PoseStamped())

    @pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
    @pytest.mark.parametrize("axis", range(3))
    def test_not_finite(self, value: float, axis: int) -> None:
        point = SOME[:3].copy()
        point[axis] = value
        messages: list[tuple[Any, Any]] = [
            (tip_from, tip_message(1, point, quaternion())),
            (goal_from, point_message(1, point)),
        ]
        for read, message in messages:
            with pytest.raises(MessageError, match="is not finite"):
                read(message)
