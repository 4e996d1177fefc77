"""When an entry of an action is stuck, and when it is only late."""

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.stuck_watch import StuckWatch

MARGIN = 0.03
REST = np.zeros(3)


def seen(watch: StuckWatch, command: FloatArray, action: FloatArray, times: int) -> list[list[int]]:
    """Show the same command and action again and again; which entries are stuck in the end."""
    for _ in range(times):
        stuck = watch.see(command, action)
    return [np.flatnonzero(side).tolist() for side in stuck]


def test_an_entry_that_keeps_still_short_of_its_command_is_stuck() -> None:
    watch = StuckWatch(3, MARGIN)
    assert seen(watch, np.array([-1.0, 0.0, 1.0]), REST, 10) == [[0], [2]]


def test_one_within_the_margin_is_not() -> None:
    watch = StuckWatch(3, MARGIN)
    assert seen(watch, np.full(3, 0.99 * MARGIN), REST, 10) == [[], []]
    assert seen(watch, np.full(3, 1.01 * MARGIN), REST, 10) == [[], [0, 1, 2]]


def test_one_on_its_way_is_not() -> None:
    watch = StuckWatch(3, MARGIN)
    for step in range(30):
        assert seen(watch, np.ones(3), np.full(3, 0.5 * MARGIN * step), 1) == [[], []]


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_command_is_given_time(direction: float) -> None:
    """An action still at an older command is not stuck until four commands have passed."""
    watch, away = StuckWatch(3, MARGIN), np.full(3, direction)
    seen(watch, REST, REST, 10)
    assert seen(watch, away, REST, 3) == [[], []]
    assert any(seen(watch, away, REST, 1))


def test_a_pause_begins_anew() -> None:
    watch = StuckWatch(3, MARGIN)
    for _ in range(20):
        assert seen(watch, np.ones(3), REST, 3) == [[], []]
        watch.pause()


@pytest.mark.parametrize("samples", [0, 1, 3, 50])
def test_continues_bit_for_bit(samples: int) -> None:
    rows = np.round(np.random.default_rng(4).uniform(-1, 1, (samples + 50, 6)), 1)
    watch = StuckWatch(3, 0.3)
    for row in rows[:samples]:
        watch.see(row[:3], 0.1 * row[3:])
    twin = StuckWatch.restore(watch.state(), 3)
    for row in rows[samples:]:
        sides = [each.see(row[:3], 0.1 * row[3:]) for each in (watch, twin)]
        np.testing.assert_array_equal(*sides)


@pytest.mark.parametrize(
    "broken",
    [
        {"commands": np.zeros((2, 4))},
        {"commands": np.zeros((5, 3))},
        {"commands": np.full((2, 3), np.nan)},
        {"action": np.zeros(4)},
        {"action": np.zeros((3, 1))},
    ],
    ids=lambda broken: f"{next(iter(broken))}-{np.shape(next(iter(broken.values())))}",
)
def test_refuses_broken_snapshots(broken: dict[str, FloatArray]) -> None:
    whole = StuckWatch(3, MARGIN).state()
    with pytest.raises(GoalBabblingError):
        StuckWatch.restore(SavedState({**whole.arrays, **broken}, whole.settings), 3)
