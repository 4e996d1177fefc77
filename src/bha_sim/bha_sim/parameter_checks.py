"""Checks that the sections of the robot's parameters share."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_sim.errors import RobotParameterError

Array = NDArray[np.float64]


class Section:
    """Base of a frozen dataclass that checks its own fields and names them in messages."""

    _name = ""

    def _fail(self, field: str, expected: str) -> None:
        where = f"{self._name}.{field}" if self._name else field
        raise RobotParameterError(f"{where} must be {expected}, got {getattr(self, field)!r}")

    def _number(self, field: str, *, low: float = 0.0, above: bool = True) -> None:
        """Make a field a float that is above `low`, or at least `low`."""
        value: Any = getattr(self, field)
        if isinstance(value, bool) or not isinstance(value, int | float | np.number):
            self._fail(field, "a number")
        number = float(value)
        if not math.isfinite(number) or number < low or (above and number == low):
            self._fail(field, f"{'above' if above else 'at least'} {low:g}")
        object.__setattr__(self, field, number)

    def _array(
        self, field: str, shape: tuple[int, ...], *, low: float = 0.0, above: bool = True
    ) -> None:
        """Make a field a read-only array of `shape` with all entries above, or at least, `low`."""
        try:
            if np.asarray(getattr(self, field)).dtype == np.bool_:
                self._fail(field, "numbers")
            array = np.array(getattr(self, field), dtype=np.float64)
        except (TypeError, ValueError):
            self._fail(field, f"numbers of shape {shape}")
        if len(shape) == 2 and array.ndim == 1:
            # A list of branches or elements: one entry a row, the same for all columns.
            array = array[:, None]
        elif shape[-1] == bellows.COUNT and array.shape[-1:] == (bellows.SEGMENTS,):
            array = np.repeat(array, bellows.CHAMBERS, axis=-1)
        try:
            array = np.broadcast_to(array, shape).copy()
        except ValueError:
            self._fail(field, f"one number or numbers of shape {shape}")
        if not np.isfinite(array).all() or (array < low).any() or (above and (array == low).any()):
            self._fail(field, f"{'above' if above else 'at least'} {low:g} everywhere")
        array.setflags(write=False)
        object.__setattr__(self, field, array)

    def _rows(self, field: str) -> int:
        """Count the branches or elements that a list describes."""
        value: Any = getattr(self, field)
        if not isinstance(value, list | tuple | np.ndarray):
            self._fail(field, "a list with one entry a branch or element")
        return len(value)
