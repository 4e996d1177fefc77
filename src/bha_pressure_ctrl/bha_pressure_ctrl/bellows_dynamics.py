"""What an equilibrium does not tell of the bellows: what they remember, and how they lag."""

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
    dead_time : Time until the lengths begin to follow the pressures [s].
    fill_lag, vent_lag : Lag with which they follow rising and falling pressures, for which a lead
        makes up [s].
    response_lag : Lag that is waited for besides [s].
    """

    memory: Array = field(default_factory=lambda: np.zeros((STATES, bellows.COUNT)))
    dead_time: float = 0.0
    fill_lag: float = 0.0
    vent_lag: float = 0.0
    response_lag: float = 0.5

    def __post_init__(self) -> None:
        memory = np.array(self.memory, dtype=np.float64)
        if memory.shape != (STATES, bellows.COUNT) or not np.all(np.isfinite(memory)):
            raise ValueError(f"memory must be finite, shape ({STATES}, {bellows.COUNT})")
        memory.setflags(write=False)
        object.__setattr__(self, "memory", memory)
        for name in TIMES:
            if not 0.0 <= getattr(self, name) <= LONGEST:
                raise ValueError(f"{name} must be from 0 to {LONGEST:g} s")


TIMES = ("dead_time", "fill_lag", "vent_lag", "response_lag")
LONGEST = 5.0
"""The longest dead time or lag that is believed [s]."""
