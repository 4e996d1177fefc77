"""Figures as JSON: numpy's numbers and arrays as plain ones, files that are whole or not there."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

from bha_common.files import atomic_write


def to_line(value: Any) -> str:
    """Return a value as one line that `json.loads` gives back exactly, NaN and infinity too."""
    return json.dumps(value, default=_plain)


def round_trip(value: Any) -> Any:
    """Return a value as it is read back from JSON: tuples as lists, numpy's numbers as plain."""
    return json.loads(to_line(value))


def write(path: Path, value: Any) -> None:
    """Write a value as JSON that every reader takes: what is not finite becomes null."""
    text = json.dumps(_finite(round_trip(value)), indent=1, allow_nan=False)
    atomic_write(path, f"{text}\n".encode())


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} is not a figure: {value!r}")


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _finite(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
