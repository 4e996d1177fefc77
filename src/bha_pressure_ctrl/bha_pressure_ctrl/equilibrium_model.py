"""The inverse equilibrium model: which pressures hold the bellows at given lengths."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.files import ModelFileError, load_versioned, save_versioned
from bha_pressure_ctrl.bellows_dynamics import TIMES, BellowsDynamics
from bha_pressure_ctrl.constrained_elm import Elm
from bha_pressure_ctrl.soft_ends import bend, bend_slopes

Array = NDArray[np.float64]

_KIND, _VERSION = "equilibrium model", 3
_SCALARS = ("length_scale", "max_pressure", "constrained", "pressure_error", "samples")
_ELM = ("input_weights", "biases", "output_weights", "direct", "offset")


class EquilibriumModelError(ValueError):
    """Samples or numbers that make no equilibrium model; the message says why."""


@dataclass(frozen=True, eq=False)
class EquilibriumModel:
    """A map from settled lengths to the pressures that hold them.

    ``pressures = ends(max_pressure * elm((lengths - mean_lengths) / length_scale))``

    where ``ends`` bends what comes near the ends of the range of pressures or beyond, so that it
    stays inside and goes on rising; a model that is not constrained is without it.

    Attributes
    ----------
    mean_lengths : Lengths that are 0 to the network [m], shape (9,).
    length_scale : Distance from them that is 1 to the network [m].
    elm : The network, nine inputs and outputs; without hidden neurons the model is affine.
    max_pressure : Upper end of the range of pressures [Pa]; the lower end is 0.
    constrained : Whether every pressure is to rise with its own length, within the range, wherever
        a length can be meant.
    pressure_error : Root mean square error in cross-validation [Pa].
    samples : Number of settled samples behind the model.
    dynamics : What holds on the way to an equilibrium.
    """

    mean_lengths: Array
    length_scale: float
    elm: Elm
    max_pressure: float
    constrained: bool
    pressure_error: float
    samples: int
    dynamics: BellowsDynamics = field(default_factory=BellowsDynamics)

    def __post_init__(self) -> None:
        object.__setattr__(self, "mean_lengths", _checked("mean_lengths", self.mean_lengths, (9,)))
        neurons = len(np.atleast_1d(self.elm.biases))
        shapes: dict[str, tuple[int, ...]] = {
            "input_weights": (neurons, 9),
            "biases": (neurons,),
            "output_weights": (9, neurons),
            "direct": (9, 9),
            "offset": (9,),
        }
        parts = {name: _checked(name, getattr(self.elm, name), shapes[name]) for name in _ELM}
        object.__setattr__(self, "elm", Elm(**parts))
        for name in ("length_scale", "max_pressure"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0.0):
                raise EquilibriumModelError(f"{name} must be above 0, got {getattr(self, name)}")
        if self.constrained and not np.all(self.lowest_slopes() > 0.0):
            falling = [bellows.NAMES[k] for k in np.flatnonzero(~(self.lowest_slopes() > 0.0))]
            raise EquilibriumModelError(
                f"the pressure of {', '.join(falling)} is not certain to rise with its length"
            )

    @classmethod
    def affine(
        cls,
        mean_lengths: Array,
        mean_pressures: Array,
        slope: Array,
        *,
        max_pressure: float = bellows.MAX_PRESSURE,
        constrained: bool = True,
        pressure_error: float = 0.0,
        samples: int = 0,
    ) -> EquilibriumModel:
        """Make a model of known numbers: ``mean_pressures + slope @ (lengths - mean_lengths)``.

        Parameters
        ----------
        mean_lengths : Lengths [m], shape (9,).
        mean_pressures : Pressures that hold them [Pa], shape (9,).
        slope : Pressure per length [Pa/m], shape (9, 9).
        max_pressure, constrained, pressure_error, samples : As of the model.
        """
        elm = Elm(
            np.zeros((0, 9)),
            np.zeros(0),
            np.zeros((9, 0)),
            np.asarray(slope) / max_pressure,
            np.asarray(mean_pressures) / max_pressure,
        )
        return cls(mean_lengths, 1.0, elm, max_pressure, constrained, pressure_error, samples)

    def pressures(self, lengths: Array) -> Array:
        """Tell the pressures that hold the bellows at `lengths`.

        Parameters
        ----------
        lengths : Bellows lengths [m], shape (9,) or (n, 9).

        Returns
        -------
        Gauge pressures [Pa], of the same shape; within the range if the model is constrained.
        """
        free = self.max_pressure * self.elm(self._inputs(lengths))
        return bend(free, self.max_pressure) if self.constrained else free

    def slopes(self, lengths: Array) -> Array:
        """Tell how each pressure changes with each length.

        Parameters
        ----------
        lengths : Bellows lengths [m], shape (9,) or (n, 9).

        Returns
        -------
        Pressure per length [Pa/m], shape (9, 9) or (n, 9, 9).
        """
        inputs = self._inputs(lengths)
        slopes = self.elm.slopes(inputs) * (self.max_pressure / self.length_scale)
        if not self.constrained:
            return slopes
        bent = bend_slopes(self.max_pressure * self.elm(inputs), self.max_pressure)
        return bent[..., None] * slopes

    def lowest_slopes(self) -> Array:
        """Bound from below how each pressure rises with its own length, before the ends bend it.

        Returns
        -------
        Pressure per length [Pa/m], shape (9,): for all lengths from `bellows.MIN_LENGTH` to
        `bellows.MAX_LENGTH` at once, in interval arithmetic. Where it is above 0, the pressure
        rises, bent or not.
        """
        low, high = (self._inputs(np.full(9, end)) for end in LENGTHS)
        return self.elm.lowest_slopes(low, high) * (self.max_pressure / self.length_scale)

    def shifted(self, pressures: Array) -> EquilibriumModel:
        """Return the model with pressures [Pa], shape (9,), added before the ends bend them.

        What it is constrained to, it keeps.
        """
        elm = replace(self.elm, offset=self.elm.offset + pressures / self.max_pressure)
        return replace(self, elm=elm)

    def save(self, path: str | os.PathLike[str], robot: str) -> None:
        """Write the model to a file that belongs to `robot`."""
        arrays = {name: getattr(self.elm, name) for name in _ELM}
        save_versioned(
            path,
            kind=_KIND,
            version=_VERSION,
            robot=robot,
            arrays={
                "mean_lengths": self.mean_lengths,
                "memory": self.dynamics.memory,
                "inertia": self.dynamics.inertia,
                **arrays,
            },
            settings={
                **{name: getattr(self, name) for name in _SCALARS},
                **{name: getattr(self.dynamics, name) for name in TIMES},
            },
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str], robot: str | None) -> EquilibriumModel:
        """Read a model of `robot`; None takes that of any.

        Raises
        ------
        ModelFileError
            When the file cannot be used for this robot. Files of versions 1 and 2 tell nothing of
            how the lengths come to rest: such a robot is to be identified again.
        """
        stored = load_versioned(path, kind=_KIND, version=_VERSION, robot=robot)
        try:
            fields: dict[str, Any] = {**stored.arrays, **stored.settings}
            elm = Elm(**{name: fields.pop(name) for name in _ELM})
            times = {name: fields.pop(name) for name in TIMES}
            dynamics = BellowsDynamics(fields.pop("memory"), fields.pop("inertia"), **times)
            return cls(elm=elm, dynamics=dynamics, **fields)
        except (AttributeError, KeyError, TypeError, ValueError) as error:
            raise ModelFileError(f"{path}: does not hold a whole model: {error}") from error

    def _inputs(self, lengths: Array) -> Array:
        inputs: Array = (lengths - self.mean_lengths) / self.length_scale
        return inputs


LENGTHS = (bellows.MIN_LENGTH, bellows.MAX_LENGTH)
"""Ends of the box in which constraints hold [m]: every length that can be commanded."""


def _checked(name: str, value: Any, shape: tuple[int, ...]) -> Array:
    array = np.array(value, dtype=np.float64)
    if array.shape != shape or not np.all(np.isfinite(array)):
        raise EquilibriumModelError(f"{name} must be finite, shape {shape}")
    array.setflags(write=False)
    return array
