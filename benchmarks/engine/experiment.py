"""What a table of `./bha paper` is made of.

A table is a module of this package with an `EXPERIMENT`. Its work is cut into runs: one function
call each, from a seed and settings to figures, which another process or machine can make. What all
runs have brought is summarised as rows and bounds, and drawn.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Settings = dict[str, Any]
"""Keyword arguments of a run besides the seed; plain values that JSON can hold."""

Figures = dict[str, Any]
"""What a run has measured; numbers, strings, and lists and dictionaries of them."""


@dataclass(frozen=True)
class Run:
    """One run that has been made."""

    seed: int
    settings: Settings
    figures: Figures


def runs_with(runs: Sequence[Run], **settings: Any) -> list[Run]:
    """Return the runs that were made with these settings, whatever their others and the seed."""
    return [run for run in runs if settings.items() <= run.settings.items()]


@dataclass(frozen=True)
class Bound:
    """A number that must be reached.

    Attributes
    ----------
    what : What is measured, with its unit.
    bound : The bound in words, such as "<= 60".
    measured : The number; None when these runs cannot tell.
    holds : Whether it is within the bound.
    """

    what: str
    bound: str
    measured: float | None
    holds: bool

    @classmethod
    def at_most(cls, what: str, limit: float, measured: float | None) -> Bound:
        """Measured must not be above the limit."""
        return cls(what, f"<= {limit:g}", measured, measured is not None and measured <= limit)

    @classmethod
    def at_least(cls, what: str, limit: float, measured: float | None) -> Bound:
        """Measured must not be below the limit."""
        return cls(what, f">= {limit:g}", measured, measured is not None and measured >= limit)

    @classmethod
    def within(cls, what: str, low: float, high: float, measured: float | None) -> Bound:
        """Measured must lie between two limits."""
        holds = measured is not None and low <= measured <= high
        return cls(what, f"{low:g} to {high:g}", measured, holds)


@dataclass(frozen=True)
class Summary:
    """A table.

    Attributes
    ----------
    rows : Its rows; the keys of the first are the heads of the columns, with units.
    bounds : What must hold.
    note : An honest word on where ours and the article's differ, for people.
    """

    rows: list[dict[str, Any]]
    bounds: list[Bound]
    note: str = ""


@dataclass(frozen=True)
class Experiment:
    """A table of the article.

    Attributes
    ----------
    name : Its name on the command line.
    claim : What the article claims, and where.
    shows : What our table shows, in one line.
    minutes : About how long it takes on two cores, with its own number of seeds.
    seeds : How many seeds it takes when nobody says another number.
    plan : Gives the settings of the runs that are made for every seed; the argument tells whether
        it must be quick (a minute in all, to see that it works).
    run : Makes one run, `run(seed, **settings)`; a function at the top level of its module.
    summarise : Makes the table of the runs.
    draw : Draws the runs into an empty figure that a reader understands without the text.
    """

    name: str
    claim: str
    shows: str
    minutes: float
    seeds: int
    plan: Callable[[bool], Sequence[Settings]]
    run: Callable[..., Figures]
    summarise: Callable[[Sequence[Run]], Summary]
    draw: Callable[[Sequence[Run], Figure], None]
