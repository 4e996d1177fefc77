"""What a learner or a part of it is made of at one moment: arrays and plain settings."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class SavedState:
    """A snapshot that can be written to a file and brought back bit for bit.

    Attributes
    ----------
    arrays : mapping of str to array
        Copies of all numbers that change while learning.
    settings : mapping of str to JSON value
        Names, counts and switches.
    """

    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)

    def part(self, name: str) -> "SavedState":
        """Return the snapshot that `joined` has put in under `name`."""
        prefix = name + "_"
        arrays = {k.removeprefix(prefix): v for k, v in self.arrays.items() if k.startswith(prefix)}
        return SavedState(arrays, self.settings.get(name, {}))

    def joined(self, **parts: "SavedState") -> "SavedState":
        """Return this snapshot together with those of its parts, each under its name."""
        arrays = {k: np.array(v) for k, v in self.arrays.items()}
        settings = dict(self.settings)
        for name, part in parts.items():
            arrays.update({f"{name}_{k}": np.array(v) for k, v in part.arrays.items()})
            settings[name] = dict(part.settings)
        return SavedState(arrays, settings)
