"""What can be wrong between a terminal and its driver, and within the terminal."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from bha_driver.errors import FaultScheduleError

FAULTS = {
    "delay": "every reply comes late",
    "drop": "replies do not come",
    "refuse": "the terminal cuts the connection and accepts no other",
    "cut": "the connection is cut once",
    "exception": "every request is answered with an exception",
    "freeze": "the inputs keep the values that they have",
    "swap": "the two bytes of every word that is read come in the wrong order",
    "restart": "the terminal restarts: away for the time, then vented and without its watchdog",
}
"""The faults by name."""


@dataclass(frozen=True)
class Fault:
    """One fault in a schedule.

    Attributes
    ----------
    name : One of `FAULTS`.
    at : When it begins [s].
    duration : How long it lasts [s].
    """

    name: str
    at: float
    duration: float

    def __post_init__(self) -> None:
        if self.name not in FAULTS:
            raise FaultScheduleError(
                f"the fault {self.name!r} is unknown; valid are {', '.join(FAULTS)}"
            )
        if not (0.0 <= self.at < math.inf and 0.0 < self.duration < math.inf):
            raise FaultScheduleError(
                f"{self.name} begins at {self.at} s and lasts {self.duration} s; it must begin at "
                "0 or later, and last longer than 0"
            )


def parse_faults(text: str) -> list[Fault]:
    """Read a schedule such as ``cut@10, delay@20+0.5, restart@30+2``: name, begin, duration.

    Raises
    ------
    FaultScheduleError
        Naming the entry that cannot be read.
    """
    faults = []
    for entry in filter(None, (part.strip() for part in text.split(","))):
        match = re.fullmatch(r"([a-z]+)@([0-9.]+)(?:\+([0-9.]+))?", entry)
        try:
            if match is None:
                raise ValueError
            faults.append(Fault(match[1], float(match[2]), float(match[3] or 0.5)))
        except FaultScheduleError:
            raise
        except ValueError:
            raise FaultScheduleError(
                f"{entry!r} is no fault; write name@begin+duration, such as delay@20+0.5; "
                f"names are {', '.join(FAULTS)}"
            ) from None
    return sorted(faults, key=lambda fault: fault.at)


def random_faults(
    seed: int, until: float, mean_gap: float, names: Iterable[str] = FAULTS
) -> list[Fault]:
    """Draw a schedule: the same seed gives the same one.

    Parameters
    ----------
    seed : Draws it.
    until : When the last one may begin [s].
    mean_gap : Mean time from the end of one to the begin of the next [s].
    names : What to draw from.
    """
    rng = np.random.default_rng(seed)
    choices = list(names)
    faults: list[Fault] = []
    time = float(rng.exponential(mean_gap))
    while time < until:
        duration = float(rng.uniform(0.02, 2.0))
        faults.append(Fault(choices[rng.integers(len(choices))], time, duration))
        time += duration + float(rng.exponential(mean_gap))
    return faults
