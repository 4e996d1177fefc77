"""Snapshots of parts within snapshots of wholes."""

import numpy as np

from bha_goal_babbling.saved_state import SavedState


def test_parts_come_back_as_they_went_in() -> None:
    """Also parts of parts, and names that begin like others."""
    inner = SavedState({"x": np.arange(3.0)}, {"a": 1})
    middle = SavedState({"y": np.zeros((0, 2))}, {"b": None}).joined(inner=inner)
    whole = SavedState({"z": np.ones(1)}, {"c": "d"}).joined(middle=middle, mid=inner)
    back = whole.part("middle")
    np.testing.assert_array_equal(back.part("inner").arrays["x"], [0.0, 1.0, 2.0])
    assert back.part("inner").settings == {"a": 1}
    assert back.arrays["y"].shape == (0, 2)
    assert set(whole.part("mid").arrays) == {"x"}


def test_joined_arrays_are_copies() -> None:
    """A snapshot does not change with its source."""
    source = np.zeros(2)
    whole = SavedState({"x": source}).joined(part=SavedState({"x": source}))
    source[:] = 1.0
    np.testing.assert_array_equal(whole.arrays["x"], [0.0, 0.0])
    np.testing.assert_array_equal(whole.part("part").arrays["x"], [0.0, 0.0])
