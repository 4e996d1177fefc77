"""Ends of ranges, on a robot whose ends depend on its posture and that follows with a lag."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.reachable_range import ReachableRange
from bha_goal_babbling.saved_state import SavedState

MARGIN = 0.03
HOME = np.array([0.2, -0.1])
LOW, HIGH = np.full(3, -2.0), np.full(3, 2.0)


class Bellows:
    """Three actions that follow commands, each to its end only, which depends on the posture."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.slopes = 0.15 * self.rng.standard_normal((2, 3, 2))
        self.middles = np.array([[-0.8, -0.6, -0.7], [0.6, 0.9, 0.7]])
        self.action = np.zeros(3)
        self.outcome = HOME.copy()

    def ends(self, outcome: FloatArray) -> FloatArray:
        return self.middles + self.slopes @ (outcome - HOME)

    def follow(self, command: FloatArray) -> None:
        """Go 70 % of the way."""
        wanted = self.action + 0.7 * (command - self.action)
        self.action = np.clip(wanted, *self.ends(self.outcome))

    def babble(self, ranges: ReachableRange, targets: int) -> None:
        """Hold random commands, at most 0.2 beyond the ends that are known, at random postures."""
        for _ in range(targets):
            self.outcome = HOME + self.rng.uniform(-1, 1, 2)
            command = self.rng.uniform(-1.3, 1.3, 3)
            low, high = ranges.at(self.outcome)
            command = np.clip(command, low - 0.2, high + 0.2)
            for _ in range(12):
                self.follow(command)
                ranges.learn(command, self.action, self.outcome)


def error(robot: Bellows, ranges: ReachableRange) -> float:
    """Return the largest distance of the ends known and those that there are."""
    outcomes = HOME + np.random.default_rng(0).uniform(-1, 1, (50, 2))
    return max(float(np.abs(ranges.at(x) - robot.ends(x)).max()) for x in outcomes)


def test_begins_with_the_limits() -> None:
    ranges = ReachableRange(HOME, LOW, HIGH, MARGIN)
    low, high = ranges.at(np.array([5.0, 5.0]))
    np.testing.assert_array_equal(low, LOW)
    np.testing.assert_array_equal(high, HIGH)


@pytest.mark.parametrize("seed", range(3))
def test_finds_the_ends_of_every_posture(seed: int) -> None:
    robot, ranges = Bellows(seed), ReachableRange(HOME, LOW, HIGH, MARGIN)
    assert error(robot, ranges) > 1.0
    robot.babble(ranges, 1500)
    assert error(robot, ranges) < MARGIN


@pytest.mark.parametrize("outwards", [0.15, -0.15])
def test_follows_ends_that_move(outwards: float) -> None:
    """Outwards a reading passes them, inwards it sticks short of them."""
    robot, ranges = Bellows(3), ReachableRange(HOME, LOW, HIGH, MARGIN)
    robot.babble(ranges, 1500)
    robot.middles += outwards * np.array([[-1.0], [1.0]])
    assert error(robot, ranges) > 0.12
    robot.babble(ranges, 1500)
    assert error(robot, ranges) < MARGIN


def test_a_reading_on_its_way_is_not_at_its_end() -> None:
    """However far behind the commands; nor one that has come near enough."""
    ranges = ReachableRange(HOME, LOW, HIGH, MARGIN)
    for t in range(60):
        ranges.learn(np.full(3, 1.5), np.full(3, -0.5 + 0.5 * MARGIN * t), HOME)
    for _ in range(20):
        ranges.learn(np.full(3, 1.5), np.full(3, 1.5 - 0.9 * MARGIN), HOME)
    np.testing.assert_array_equal(ranges.at(HOME), [LOW, HIGH])


def test_a_reading_that_keeps_still_is() -> None:
    """At that posture, however far out, the end comes to where it sticks; the other end stays."""
    ranges = ReachableRange(HOME, LOW, HIGH, MARGIN)
    place = HOME + np.array([3.0, 1.0])
    for _ in range(40):
        ranges.learn(np.array([1.5, 0.0, -1.5]), np.array([0.3, 0.0, -0.4]), place)
    low, high = ranges.at(place)
    np.testing.assert_allclose(high, [0.3, 2.0, 2.0], atol=1e-4)
    np.testing.assert_allclose(low, [-2.0, -2.0, -0.4], atol=1e-4)


finite = st.floats(-10, 10)


@given(
    low=arrays(float, (3, 3), elements=finite),
    high=arrays(float, (3, 3), elements=finite),
    outcome=arrays(float, 2, elements=finite),
)
def test_low_is_never_above_high(low: FloatArray, high: FloatArray, outcome: FloatArray) -> None:
    """Ends that cross meet halfway; others are the linear functions that they are."""
    state = ReachableRange(HOME, LOW, HIGH, MARGIN).state()
    ranges = ReachableRange.restore(
        SavedState({**state.arrays, "low": low, "high": high}, state.settings)
    )
    lowest, highest = ranges.at(outcome)
    assert (lowest <= highest).all()
    place = np.array([*(outcome - HOME), 1.0])
    plain = np.stack([low @ place, high @ place])
    crossed = plain[0] > plain[1]
    expected = np.where(crossed, plain.mean(axis=0), plain)
    np.testing.assert_allclose([lowest, highest], expected, atol=1e-10)


@pytest.mark.parametrize("samples", [0, 1, 3, 50])
def test_continues_bit_for_bit(samples: int) -> None:
    rng = np.random.default_rng(4)
    ranges = ReachableRange(HOME, LOW, HIGH, MARGIN)
    data = np.round(rng.uniform(-1, 1, (samples + 50, 8)), 1)
    for row in data[:samples]:
        ranges.learn(row[:3], np.zeros(3), row[6:])
    state = ranges.state()
    twins = [ReachableRange.restore(state), ReachableRange.restore(state)]
    for row in data[samples:]:
        for each in (ranges, *twins):
            each.learn(row[:3], np.zeros(3), row[6:])
        for twin in twins:
            np.testing.assert_array_equal(ranges.at(row[6:]), twin.at(row[6:]))
    assert (ranges.at(HOME)[1] < HIGH).any()


@pytest.mark.parametrize(
    "broken",
    [
        {"home": np.zeros(3)},
        {"home": np.zeros((2, 1))},
        {"low": np.zeros((3, 2))},
        {"low": np.zeros((4, 3))},
        {"high": np.full((3, 3), np.nan)},
        {"watch_action": np.zeros(4)},
    ],
    ids=lambda broken: f"{next(iter(broken))}-{np.shape(next(iter(broken.values())))}",
)
def test_refuses_broken_snapshots(broken: dict[str, FloatArray]) -> None:
    whole = ReachableRange(HOME, LOW, HIGH, MARGIN).state()
    with pytest.raises(GoalBabblingError):
        ReachableRange.restore(SavedState({**whole.arrays, **broken}, whole.settings))
