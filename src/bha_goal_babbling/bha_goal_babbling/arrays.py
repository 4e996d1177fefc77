"""Checked conversion of what callers pass into float arrays of a known shape."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bha_goal_babbling.errors import InvalidArrayError

FloatArray = NDArray[np.float64]

LARGEST = 1e100
"""Largest magnitude of an entry that is taken for a number."""


def vector(name: str, value: ArrayLike, size: int | None = None) -> FloatArray:
    """Return a copy of `value` as a finite vector.

    Parameters
    ----------
    name : str
        What the vector is called in the message of an error.
    value : array_like
        Shape (size,).
    size : int, optional
        Number of entries that are expected; any number above zero without it.

    Raises
    ------
    InvalidArrayError
        If the shape differs or an entry is not finite, or larger than `LARGEST`.
    """
    array = _floats(name, value)
    if array.ndim != 1 or array.size == 0 or (size is not None and array.size != size):
        wanted = "(n,) with n >= 1" if size is None else f"({size},)"
        raise InvalidArrayError(f"{name} has shape {array.shape}, expected {wanted}")
    # Also false for NaN. Squares of larger numbers would no longer be finite.
    if not float(np.abs(array).max()) <= LARGEST:
        raise InvalidArrayError(
            f"{name} must be finite and at most {LARGEST:g}, got {array.tolist()}"
        )
    return array


def matrix(name: str, value: ArrayLike, columns: int | None = None) -> FloatArray:
    """Return a copy of `value` as a finite matrix.

    Parameters
    ----------
    name : str
        What the matrix is called in the message of an error.
    value : array_like
        Shape (rows, columns), at least one row.
    columns : int, optional
        Number of columns that are expected; any number above zero without it.

    Raises
    ------
    InvalidArrayError
        If the shape differs or an entry is not finite, or larger than `LARGEST`.
    """
    array = _floats(name, value)
    fits = array.ndim == 2 and array.size > 0 and (columns is None or array.shape[1] == columns)
    if not fits:
        wanted = "(N, n)" if columns is None else f"(N, {columns})"
        raise InvalidArrayError(f"{name} has shape {array.shape}, expected {wanted} with N >= 1")
    if not float(np.abs(array).max()) <= LARGEST:
        raise InvalidArrayError(f"{name} must be finite and at most {LARGEST:g} in every row")
    return array


def matrix_or_empty(name: str, value: ArrayLike, columns: int) -> FloatArray:
    """Return a copy of `value` as a finite matrix, shape (rows, columns), that may have no row."""
    array = _floats(name, value)
    return array if array.shape == (0, columns) else matrix(name, array, columns)


def _floats(name: str, value: ArrayLike) -> FloatArray:
    try:
        return np.array(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidArrayError(f"{name} must hold numbers only: {error}") from None
