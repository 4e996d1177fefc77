"""What a robot did over a while, as arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Recording:
    """What the robot did over a while.

    Attributes
    ----------
    lengths, commands, pressures, tips : Lists of (time [s], array): measured and commanded lengths
        [m] and pressures [Pa], shape (9,), and the tip [m], shape (3,).
    """

    def __init__(self) -> None:
        self.lengths: list[tuple[float, Array]] = []
        self.commands: list[tuple[float, Array]] = []
        self.pressures: list[tuple[float, Array]] = []
        self.tips: list[tuple[float, Array]] = []
