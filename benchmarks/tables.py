"""The tables of `./bha paper` by their names."""

import importlib
import importlib.util

from benchmarks.experiment import Experiment

NAMES = (
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
    "bha-plant",
    "bha-control",
    "bha-2d",
    "bha-3d",
    "bha-feedback",
    "bha-range",
    "bha-use",
)
"""In the order of `list`; the table NAME is the module benchmarks.NAME, dashes as underscores."""


class UnknownTableError(ValueError):
    """There is no table of this name."""


def available() -> list[str]:
    """Return the names of the tables that this checkout holds."""
    return [name for name in NAMES if importlib.util.find_spec(_module(name)) is not None]


def find(name: str) -> Experiment:
    """Return a table.

    Raises
    ------
    UnknownTableError
        If there is none of this name; the message lists those that there are.
    """
    if name not in available():
        raise UnknownTableError(f"there is no table {name!r}; there are {', '.join(available())}")
    experiment: Experiment = importlib.import_module(_module(name)).EXPERIMENT
    return experiment


def _module(name: str) -> str:
    return f"benchmarks.{name.replace('-', '_')}"
