"""The tables of `./bha paper` by their names."""

import importlib

from benchmarks.engine.experiment import Experiment

_ROOMS = {
    "arm": (
        "toy",
        "unfold",
        "dimensions",
        "learning-rate",
        "linear",
        "non-convex",
        "drift",
        "branches",
        "workspace",
        "interest",
        "baselines",
    ),
    "trunk": (
        "bha-plant",
        "bha-control",
        "bha-2d",
        "bha-3d",
        "bha-feedback",
        "bha-range",
        "bha-use",
    ),
}

NAMES = tuple(name for names in _ROOMS.values() for name in names)
"""In the order of `list`."""

_MODULES = {
    name: f"benchmarks.{room}.{name.replace('-', '_')}"
    for room, names in _ROOMS.items()
    for name in names
}


class UnknownTableError(ValueError):
    """There is no table of this name."""


def find(name: str) -> Experiment:
    """Return a table.

    Raises
    ------
    UnknownTableError
        If there is none of this name; the message lists those that there are.
    """
    if name not in _MODULES:
        raise UnknownTableError(f"there is no table {name!r}; there are {', '.join(NAMES)}")
    experiment: Experiment = importlib.import_module(_MODULES[name]).EXPERIMENT
    return experiment
