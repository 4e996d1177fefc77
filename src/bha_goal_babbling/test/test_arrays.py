"""Conversion of arrays: copies, shapes, finiteness."""

import numpy as np
import pytest

from bha_goal_babbling.arrays import matrix, matrix_or_empty, vector
from bha_goal_babbling.errors import InvalidArrayError


def test_returns_copies_as_floats() -> None:
    """Lists and integers are fine."""
    given = np.array([1, 2, 3])
    got = vector("a", given, 3)
    got[0] = 9.0
    assert given[0] == 1
    assert got.dtype == np.float64
    assert matrix("a", [[1, 2]], 2).shape == (1, 2)


@pytest.mark.parametrize(
    "value", [1.0, [], [[1.0]], [1.0, 2.0], "text", [1.0, [2.0]], None, [None]]
)
def test_refuses_what_is_no_vector_of_three(value: object) -> None:
    """The message names the vector."""
    with pytest.raises(InvalidArrayError, match="speed"):
        vector("speed", value, 3)  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e200])
def test_refuses_numbers_that_spoil_everything(bad: float) -> None:
    """NaN, infinity, and numbers whose square is infinite."""
    with pytest.raises(InvalidArrayError, match="finite"):
        vector("speed", [0.0, bad])


@pytest.mark.parametrize("value", [[1.0], [[1.0, 2.0, 3.0]], np.empty((0, 2)), [[1.0, np.nan]]])
def test_refuses_what_is_no_matrix_of_two_columns(value: object) -> None:
    """Rows may be many but not none."""
    with pytest.raises(InvalidArrayError, match="grid"):
        matrix("grid", value, 2)  # type: ignore[arg-type]


def test_a_matrix_may_be_allowed_to_be_empty() -> None:
    """But must have its columns all the same, and be finite."""
    given = np.ones((2, 3))
    got = matrix_or_empty("path", given, 3)
    got[:] = 9.0
    assert (given == 1.0).all()
    assert matrix_or_empty("path", np.empty((0, 3)), 3).shape == (0, 3)
    for bad in (np.empty((0, 2)), np.ones((2, 2)), np.zeros(3), np.full((1, 3), np.nan)):
        with pytest.raises(InvalidArrayError, match="path"):
            matrix_or_empty("path", bad, 3)
