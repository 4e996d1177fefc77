"""What an equilibrium does not tell: how bellows remember and lag, and how the trunk swings."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_pressure_ctrl.bellows_memory import STATES

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class BellowsDynamics:
    """Numbers of one robot, as identified; the defaults are those of a robot nobody asked yet.

    Then nothing is made up for, and what lags is given time: a slow robot is quicker than expected,
    and is not pushed.

    Attributes
    ----------
    memory : Pressure per state of `BellowsMemory` [Pa/m], shape (STATES, 9).
    inertia : Pressure per acceleration [Pa s^2/m], shape (9, 9).
    dead_time : Time until the lengths begin to follow the pressures [s].
    fill_lag, vent_lag : Lag with which they follow rising and falling pressures, for which a lead
        makes up [s].
    response_lag : Lag that is waited for besides [s].
    """

    memory: Array = field(default_factory=lambda: np.zeros((STATES, bellows.COUNT)))
    inertia: Array = field(default_factory=lambda: np.zeros((bellows.COUNT, bellows.COUNT)))
    dead_time: float = 0.0
    fill_lag: float = 0.0
    vent_lag: float = 0.0
    response_lag: float = 0.5

    def __post_init__(self) -> None:
        for name, rows in (("memory", STATES), ("inertia", bellows.COUNT)):
            array = np.array(getattr(self, name), dtype=np.float64)
            if array.shape != (rows, bellows.COUNT) or not np.all(np.isfinite(array)):
                raise ValueError(f"{name} must be finite, shape ({rows}, {bellows.COUNT})")
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        for name in TIMES:
            if not 0.0 <= getattr(self, name) <= LONGEST:
                raise ValueError(f"{name} must be from 0 to {LONGEST:g} s")


TIMES = ("dead_time", "fill_lag", "vent_lag", "response_lag")
LONGEST = 5.0
"""The longest dead time or lag that is believed [s]."""
