"""The inverse equilibrium model: which pressures hold the bellows at given lengths."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.files import ModelFileError, load_versioned, save_versioned

Array = NDArray[np.float64]

_KIND, _VERSION = "equilibrium model", 1
MIN_SAMPLES = 2 * (bellows.COUNT + 1)
"""Fewest settled samples that a fit is made from: twice the unknowns of a bellows."""


class EquilibriumModelError(ValueError):
    """Samples that no equilibrium model can be fitted to; the message says why."""


@dataclass(frozen=True)
class EquilibriumModel:
    """An affine map from settled lengths to the pressures that hold them.

    ``pressures = mean_pressures + slope @ (lengths - mean_lengths)``

    Attributes
    ----------
    mean_lengths : Mean of the samples' lengths [m], shape (9,).
    mean_pressures : Mean of the samples' pressures [Pa], shape (9,).
    slope : Pressure per length [Pa/m], shape (9, 9).
    pressure_error : Root mean square error in cross-validation [Pa].
    samples : Number of settled samples behind the model.
    """

    mean_lengths: Array
    mean_pressures: Array
    slope: Array
    pressure_error: float
    samples: int

    def __post_init__(self) -> None:
        shapes = {"mean_lengths": (9,), "mean_pressures": (9,), "slope": (9, 9)}
        for name, shape in shapes.items():
            array = np.array(getattr(self, name), dtype=np.float64)
            if array.shape != shape or not np.all(np.isfinite(array)):
                raise EquilibriumModelError(f"{name} must be finite, shape {shape}")
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def pressures(self, lengths: Array) -> Array:
        """Tell the pressures that hold the bellows at `lengths`.

        Parameters
        ----------
        lengths : Bellows lengths [m], shape (9,) or (n, 9).

        Returns
        -------
        Gauge pressures [Pa], of the same shape; not clipped to any range.
        """
        return self.mean_pressures + (lengths - self.mean_lengths) @ self.slope.T

    def save(self, path: str | os.PathLike[str], robot: str) -> None:
        """Write the model to a file that belongs to `robot`."""
        arrays = {name: getattr(self, name) for name in ("mean_lengths", "mean_pressures", "slope")}
        settings = {"pressure_error": self.pressure_error, "samples": self.samples}
        save_versioned(
            path, kind=_KIND, version=_VERSION, robot=robot, arrays=arrays, settings=settings
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str], robot: str | None) -> EquilibriumModel:
        """Read a model of `robot`; None takes that of any.

        Raises
        ------
        ModelFileError
            When the file cannot be used for this robot.
        """
        stored = load_versioned(path, kind=_KIND, version=_VERSION, robot=robot)
        try:
            fields: dict[str, Any] = {**stored.arrays, **stored.settings}
            return cls(**fields)
        except (TypeError, ValueError) as error:
            raise ModelFileError(f"{path}: does not hold a whole model: {error}") from error


def fit_equilibrium_model(
    lengths: Array, pressures: Array, *, ridge: float = 1e-3, folds: int = 5
) -> EquilibriumModel:
    """Fit the model to settled samples by ridge regression.

    Parameters
    ----------
    lengths : Settled lengths [m], shape (n, 9).
    pressures : Pressures that held them [Pa], shape (n, 9).
    ridge : Penalty on the slope, relative to the mean variance of a length.
    folds : Number of parts for cross-validation.

    Raises
    ------
    EquilibriumModelError
        When the samples are too few, not finite, or do not move every bellows.
    """
    count = len(lengths)
    if lengths.shape != (count, bellows.COUNT) or pressures.shape != (count, bellows.COUNT):
        raise EquilibriumModelError("lengths and pressures must both have shape (n, 9)")
    if count < MIN_SAMPLES:
        raise EquilibriumModelError(f"{count} settled samples; at least {MIN_SAMPLES} are needed")
    if not (np.all(np.isfinite(lengths)) and np.all(np.isfinite(pressures))):
        raise EquilibriumModelError("lengths and pressures must be finite")
    still = [bellows.NAMES[k] for k in np.flatnonzero(np.ptp(lengths, axis=0) < 1e-3)]
    if still:
        raise EquilibriumModelError(
            f"the length of {', '.join(still)} hardly changed (less than 1 mm): "
            "is the robot under pressure, and are its potentiometers connected?"
        )
    errors = np.empty_like(pressures)
    parts = np.arange(count) % folds
    for part in range(folds):
        test = parts == part
        mean_l, mean_p, slope = _ridge(lengths[~test], pressures[~test], ridge)
        errors[test] = mean_p + (lengths[test] - mean_l) @ slope.T - pressures[test]
    mean_l, mean_p, slope = _ridge(lengths, pressures, ridge)
    return EquilibriumModel(mean_l, mean_p, slope, float(np.sqrt(np.mean(errors**2))), count)


def _ridge(lengths: Array, pressures: Array, ridge: float) -> tuple[Array, Array, Array]:
    mean_l, mean_p = lengths.mean(axis=0), pressures.mean(axis=0)
    x, y = lengths - mean_l, pressures - mean_p
    gram = x.T @ x
    penalty = ridge * np.trace(gram) / bellows.COUNT
    return mean_l, mean_p, np.linalg.solve(gram + penalty * np.eye(bellows.COUNT), x.T @ y).T
