"""Averages over the last moments, by the times of the messages alone."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_goal_babbling.observation_window import LONGEST_WAIT, ObservationWindow

SPAN = 200
ONE = np.ones(9)
TIP = np.array([1.0, 2.0, 3.0])


def test_nothing_was_seen() -> None:
    window = ObservationWindow(SPAN)
    assert window.at(1000) is None
    assert window.newest_tip is None


def test_lengths_without_a_tip() -> None:
    window = ObservationWindow(SPAN)
    window.add_lengths(1000, ONE)
    seen = window.at(1000)
    assert seen is not None
    np.testing.assert_array_equal(seen.lengths, ONE)
    assert seen.tip is None


def test_a_tip_without_lengths_is_no_observation() -> None:
    window = ObservationWindow(SPAN)
    window.add_tip(1000, TIP)
    assert window.at(1000) is None
    assert window.newest_tip == 1000


def test_averages_what_lies_in_the_span_that_ends_now() -> None:
    """Its beginning left out, its end put in."""
    window = ObservationWindow(SPAN)
    for time in range(600, 1101, 20):
        window.add_lengths(time, time * ONE)
    for time in range(600, 1101, 100):
        window.add_tip(time, time * TIP)
    seen = window.at(1000)
    assert seen is not None
    np.testing.assert_allclose(seen.lengths, np.mean(np.arange(820, 1001, 20)) * ONE)
    assert seen.tip is not None
    np.testing.assert_allclose(seen.tip, 950 * TIP)


def test_an_old_tip_is_none() -> None:
    """What was learned from it would belong to another posture."""
    window = ObservationWindow(SPAN)
    window.add_tip(1000, TIP)
    for time, there in ((1199, True), (1200, False), (5000, False)):
        window.add_lengths(time, ONE)
        seen = window.at(time)
        assert seen is not None
        assert (seen.tip is not None) == there
    assert window.newest_tip == 1000


def test_old_lengths_are_no_observation() -> None:
    window = ObservationWindow(SPAN)
    window.add_lengths(1000, ONE)
    assert window.at(1200) is None


def test_the_future_does_not_count() -> None:
    """A message may come before the average is asked for."""
    window = ObservationWindow(SPAN)
    window.add_lengths(1000, ONE)
    window.add_lengths(1020, 9 * ONE)
    seen = window.at(1000)
    assert seen is not None
    np.testing.assert_array_equal(seen.lengths, ONE)


def test_can_be_asked_as_late_as_a_tip_may_come() -> None:
    """The lengths go on meanwhile."""
    window, late = ObservationWindow(SPAN), round(LONGEST_WAIT * 1e9)
    for time in (800, 820, 1000, 1000 + late):
        window.add_lengths(time, time * ONE)
    window.add_tip(990, TIP)
    seen = window.at(1000)
    assert seen is not None
    np.testing.assert_allclose(seen.lengths, 910 * ONE)
    np.testing.assert_array_equal(seen.tip, TIP)


def test_clear_forgets_everything() -> None:
    window = ObservationWindow(SPAN)
    window.add_lengths(1000, ONE)
    window.add_tip(1000, TIP)
    window.clear()
    assert window.at(1000) is None
    assert window.newest_tip is None


def test_memory_does_not_grow() -> None:
    second = 1_000_000_000
    window = ObservationWindow(second)
    for time in range(0, 100 * second, second // 10):
        window.add_lengths(time, ONE)
        window.add_tip(time, TIP)
    kept = 10 * (1 + LONGEST_WAIT)
    assert len(window._lengths) <= kept
    assert len(window._tips) <= kept


@pytest.mark.parametrize("span", [0, 1])
def test_the_shortest_span_sees_what_is_of_this_very_time(span: int) -> None:
    window = ObservationWindow(span)
    window.add_lengths(999, ONE)
    window.add_lengths(1000, 2 * ONE)
    seen = window.at(1000)
    assert seen is not None
    np.testing.assert_array_equal(seen.lengths, 2 * ONE)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.integers(1, 50), min_size=1, max_size=30),
    st.randoms(use_true_random=False),
)
def test_does_not_depend_on_the_order_in_which_topics_arrive(
    steps: list[int], random: object
) -> None:
    """Lengths and tips come on two topics; only the order on each is sure."""
    times = list(itertools.accumulate(steps))
    lengths = [("add_lengths", time, np.full(9, float(time))) for time in times]
    tips = [("add_tip", time, np.full(3, float(time))) for time in times]
    windows = ObservationWindow(SPAN), ObservationWindow(SPAN)
    for name, time, value in lengths + tips:
        getattr(windows[0], name)(time, value)
    waiting = [lengths, tips]
    while any(waiting):
        chosen = random.choice([queue for queue in waiting if queue])  # type: ignore[attr-defined]
        name, time, value = chosen.pop(0)
        getattr(windows[1], name)(time, value)
    first, second = (window.at(times[-1]) for window in windows)
    assert first is not None
    assert second is not None
    np.testing.assert_array_equal(first.lengths, second.lengths)
    np.testing.assert_array_equal(first.tip, second.tip)
