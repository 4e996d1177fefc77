"""Ends that show on the way to a goal, and how long they count."""

import numpy as np

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.found_ends import FoundEnds

REST = [0.2, 0.2]
COMMAND = np.array([0.20, 0.30, 0.10, *REST])
GOAL = np.array([0.2, -0.1])


def found_at(*lengths: float, times: int = 10) -> FoundEnds:
    """Return what is known once the robot has stayed at some lengths [m]."""
    ends = FoundEnds(5)
    ends.begin(GOAL)
    for _ in range(times):
        ends.see(COMMAND, np.array([*lengths, *REST]))
    return ends


def known(ends: FoundEnds) -> list[FloatArray]:
    return [ends.low, ends.high]


NOTHING = [[-np.inf] * 5, [np.inf] * 5]


def test_a_length_that_stays_short_of_its_command_shows_an_end() -> None:
    ends = found_at(0.201, 0.28, 0.12)
    np.testing.assert_array_equal(
        known(ends), [[-np.inf, -np.inf, 0.12, -np.inf, -np.inf], [np.inf, 0.28, *3 * [np.inf]]]
    )
    assert ends.see(COMMAND, np.array([0.201, 0.28, 0.12, *REST]))


def test_three_millimetres_are_no_noise() -> None:
    """A length that does not move counts by millimetres: they add up to centimetres at the tip."""
    ends = found_at(0.201, 0.297, 0.103)
    np.testing.assert_array_equal([ends.high[1], ends.low[2]], [0.297, 0.103])


def test_lengths_that_follow_show_none() -> None:
    ends = found_at(0.201, 0.299, 0.101)
    np.testing.assert_array_equal(known(ends), NOTHING)
    assert not ends.see(COMMAND, np.array([0.201, 0.299, 0.101, *REST]))


def test_a_length_that_still_comes_nearer_is_not_at_an_end() -> None:
    """Bellows that vent sink for seconds: steps of 1 mm a command are small and lead on."""
    ends = FoundEnds(5)
    ends.begin(GOAL)
    way = [0.15 * 0.8**k for k in range(60)]  # what is left to go
    changed = [ends.see(COMMAND, COMMAND + np.array([0, 0, left, 0, 0])) for left in way]
    assert not any(changed)
    stops = np.maximum(way, 0.012)  # an end 12 mm above what is asked for
    seen = [ends.see(COMMAND, COMMAND + np.array([0, 0, left, 0, 0])) for left in stops]
    assert any(seen)
    assert abs(ends.low[2] - 0.112) < 1e-3


def test_a_length_that_goes_further_moves_the_end() -> None:
    ends = found_at(0.201, 0.28, 0.12)
    ends.see(COMMAND, np.array([0.201, 0.29, 0.11, *REST]))
    np.testing.assert_array_equal(
        known(ends), [[-np.inf, -np.inf, 0.11, -np.inf, -np.inf], [np.inf, 0.29, *3 * [np.inf]]]
    )


def test_they_count_near_the_goal_and_are_forgotten_elsewhere() -> None:
    ends = found_at(0.20, 0.28, 0.10)
    for step in (0.03, 0.06, 0.09):
        ends.follow(GOAL + np.array([step, 0.0]))
        assert ends.high[1] == 0.28
    ends.follow(GOAL + np.array([0.11, 0.0]))
    np.testing.assert_array_equal(known(ends), NOTHING)


def test_what_feedback_has_made_up_for_does_not_jump() -> None:
    """Once the target has moved by more than 1 cm an end is where the command is."""
    for moved, low, high in ((0.009, 0.12, 0.28), (0.011, COMMAND[2], COMMAND[1])):
        ends = FoundEnds(5)
        ends.begin(GOAL)
        ends.follow(GOAL + np.array([moved, 0.0]))
        for _ in range(10):
            ends.see(COMMAND, np.array([0.201, 0.28, 0.12, *REST]))
        assert (ends.low[2], ends.high[1]) == (low, high)
    # The way to the next goal is feed-forward again.
    ends.begin(GOAL)
    for _ in range(10):
        ends.see(COMMAND, np.array([0.201, 0.28, 0.12, *REST]))
    assert (ends.low[2], ends.high[1]) == (0.12, 0.28)


def test_a_new_goal_begins_anew() -> None:
    """What was commanded for the one before is forgotten, too."""
    ends = found_at(0.20, 0.28, 0.10)
    ends.begin(GOAL)
    np.testing.assert_array_equal(known(ends), NOTHING)
    for _ in range(3):
        assert not ends.see(COMMAND, np.array([0.20, 0.28, 0.10, *REST]))


NOT_DRIVEN = np.array([0.17, 0.17, 0.10, 0.17, 0.17])


def not_driven() -> FoundEnds:
    ends = found_at(0.20, 0.28, 0.10)
    changed = [ends.see(COMMAND, NOT_DRIVEN) for _ in range(10)]
    assert any(changed)
    assert not any(changed[-5:])
    return ends


def test_a_robot_that_is_not_driven_is_at_no_end() -> None:
    """Whatever it had found before; until it is to go elsewhere."""
    ends = not_driven()
    assert ends.given_up
    np.testing.assert_array_equal(known(ends), NOTHING)
    ends.begin(GOAL)
    assert not ends.given_up


def test_a_robot_that_follows_again_shows_its_ends_again() -> None:
    """It may have been slow rather than not driven."""
    ends = not_driven()
    lengths = np.array([0.20, 0.28, 0.10, *REST])
    for share in (0.5, 0.8):  # most are on their way yet
        assert not ends.see(COMMAND, share * lengths + (1.0 - share) * NOT_DRIVEN)
        assert ends.given_up
    changed = [ends.see(COMMAND, lengths) for _ in range(6)]
    assert not changed[0]
    assert all(changed[-3:])
    assert not ends.given_up
    assert ends.high[1] == 0.28
