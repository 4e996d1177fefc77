"""Looks at a terminal without ever writing to it: what it is, what it measures, how fast."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_driver.plausibility import Plausibility
from bha_driver.scaling import Scaling
from bha_driver.terminal import Terminal
from bha_driver.terminal_map import TerminalMap

Array = NDArray[np.float64]

_PERIOD = 0.02  # [s]


@dataclass(frozen=True, eq=False)
class Survey:
    """What was seen of a terminal.

    Attributes
    ----------
    raw : Mean raw lengths [counts], shape (9,).
    lengths, length_noise : Mean and standard deviation of the lengths [m], shape (9,).
    pressures : Mean measured pressures [Pa], shape (9,).
    round_trip, longest_round_trip : Median and longest time of a read [s].
    watchdog : What its register holds; None when the map names none.
    problems : What is wrong, for people; empty when all is well.
    """

    raw: Array
    lengths: Array
    length_noise: Array
    pressures: Array
    round_trip: float
    longest_round_trip: float
    watchdog: int | None
    problems: list[str]


def survey(
    terminal: TerminalMap, readings: int = 50, wait: Callable[[float], None] = time.sleep
) -> Survey:
    """Connect, hold the identity against the map, and read for a while; nothing is written.

    Parameters
    ----------
    terminal : The terminal's map.
    readings : How often the inputs are read.
    wait : Waits for a time [s].

    Raises
    ------
    TerminalError
        When there is no connection, another terminal, or no answer.
    """
    link, scaling = Terminal(terminal), Scaling(terminal)
    blocks, times = [], []
    try:
        link.connect()
        watchdog = link.watchdog()
        link.set_points()  # what activation needs
        for _ in range(readings):
            begin = time.perf_counter()
            blocks.append(link.read())
            times.append(time.perf_counter() - begin)
            wait(_PERIOD)
    finally:
        link.close()
    raw = np.array([scaling.raw_lengths(block) for block in blocks])
    lengths = np.array([scaling.lengths(block) for block in blocks])
    pressures = np.array([scaling.pressures(block) for block in blocks])
    found = Survey(
        raw.mean(axis=0),
        lengths.mean(axis=0),
        lengths.std(axis=0),
        pressures.mean(axis=0),
        float(np.median(times)),
        float(np.max(times)),
        watchdog,
        [],
    )
    found.problems.extend(_problems(terminal, found))
    return found


def _problems(terminal: TerminalMap, found: Survey) -> list[str]:
    problems = []
    plausibility = Plausibility(terminal.limits)
    for name, length in zip(bellows.NAMES, found.lengths, strict=True):
        reason = plausibility.out_of_range(np.array([length]))
        if reason:
            problems.append(
                f"{name} seems to be {length:.4f} m long; {terminal.limits.shortest:g} to "
                f"{terminal.limits.longest:g} m are believed: look at its register, wiring, scale"
            )
    for name, noise in zip(bellows.NAMES, found.length_noise, strict=True):
        if noise > 0.5 * terminal.limits.length_step:
            problems.append(
                f"{name} scatters by {noise * 1e3:.1f} mm: look at its cable, shield and supply"
            )
    for name, pressure in zip(bellows.NAMES, found.pressures, strict=True):
        if abs(pressure) > 0.1 * terminal.limits.pressure:
            problems.append(
                f"{name} seems to hold {pressure:.0f} Pa although nobody drives it: look at its "
                "register and scale, and whether someone else is connected"
            )
    if found.longest_round_trip > 0.5 * terminal.timeouts.request:
        problems.append(
            f"an answer took {found.longest_round_trip * 1e3:.1f} ms; timeouts.request is "
            f"{terminal.timeouts.request * 1e3:.0f} ms: use a cable of its own, or allow more"
        )
    return problems
