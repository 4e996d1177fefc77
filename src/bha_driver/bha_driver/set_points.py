"""The set-points that go to the terminal: within the range, at a limited rate, never negative."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_driver.scaling import Scaling
from bha_driver.terminal_map import TerminalMap

Array = NDArray[np.float64]
Words = NDArray[np.int64]


class SetPoints:
    """Moves set-points towards what is wanted, and knows what the terminal may hold.

    Parameters
    ----------
    terminal : The terminal's map with its limits.
    period : Time between two cycles [s]; a pressure never changes by more than one period's worth
        from one write to the next, however late it is.
    """

    def __init__(self, terminal: TerminalMap, period: float) -> None:
        self._limits, self._period = terminal.limits, period
        self._scaling = Scaling(terminal)
        self._last: float | None = None  # time of the last decision
        self._applied = np.zeros(bellows.COUNT)
        self._decided_on_nothing = True
        self._pressing = False

    @property
    def applied(self) -> Array:
        """Pressures that were decided on last [Pa], shape (9,)."""
        return self._applied.copy()

    @property
    def pressing(self) -> bool:
        """Whether the terminal may hold pressures, as far as is known."""
        return self._pressing

    def elapsed(self, time: float) -> float:
        """Tell how much time counts for this decision [s]; `time` is now [s]."""
        last, self._last = self._last, time
        return 0.0 if last is None else min(max(time - last, 0.0), self._period)

    def begin(self) -> None:
        """Let no time count for the next decision."""
        self._last = None

    def move(self, wanted: Array, elapsed: float) -> Words:
        """Decide on the set-points to write.

        Parameters
        ----------
        wanted : Pressures to go to [Pa], shape (9,), finite.
        elapsed : Time that counts for it [s].

        Returns
        -------
        Raw set-points, shape (9,), as one block.
        """
        target = np.minimum(wanted, self._limits.pressure)
        step = self._limits.pressure_rate * elapsed
        self._applied = np.clip(target, self._applied - step, self._applied + step)
        block = self._scaling.set_points(self._applied)
        self._decided_on_nothing = bool(np.array_equal(block, self._scaling.vented))
        # What is not confirmed may have been taken all the same.
        self._pressing = self._pressing or not self._decided_on_nothing
        return block

    def confirmed(self) -> None:
        """Take note that the terminal has taken the last set-points."""
        self._pressing = not self._decided_on_nothing

    def begin_at_nothing(self) -> None:
        """Go on from no pressure: the terminal has vented, or nobody knows what it holds."""
        self._applied = np.zeros(bellows.COUNT)
