"""Fits an equilibrium model to settled samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_common.settings import check_settings, setting
from bha_pressure_ctrl.constrained_elm import (
    ConstraintError,
    Penalties,
    draw_hidden_layer,
    fit_elm,
    fit_rising_elm,
)
from bha_pressure_ctrl.equilibrium_model import (
    LENGTHS,
    EquilibriumModel,
    EquilibriumModelError,
)

Array = NDArray[np.float64]

MIN_SAMPLES = 2 * (bellows.COUNT + 1)
"""Fewest settled samples that a fit is made from: twice the unknowns of an affine map."""

_FOLDS = 5
_TREND_SAMPLES = 60.0  # number of samples that make a unit of time for the penalty on the trend


@dataclass(frozen=True)
class ModelSettings:
    """What equilibrium model is fitted, and how."""

    neurons: int = setting(100, "Hidden neurons; 0 fits an affine map", low=0, high=2000)
    spread: float = setting(
        0.4, "Spread of a neuron's input over the samples; more bends more", low=0.01, high=10.0
    )
    single: float = setting(
        0.9, "Share of the neurons that look at the length of one bellows only", low=0.0, high=1.0
    )
    ridge: float = setting(0.2, "Penalty on the weights of the neurons", low=1e-9)
    direct_ridge: float = setting(
        1e-3, "Penalty on the affine part, relative to the variance of a length", low=0.0
    )
    constrained: bool = setting(
        True, "Whether every pressure must rise with its own length, within the range of pressures"
    )
    min_slope: float = setting(
        1e5, "What every pressure must rise at least with its own length [Pa/m]", low=1.0, high=4e5
    )
    trend: bool = setting(True, "Whether the samples are taken to drift evenly in time")

    def __post_init__(self) -> None:
        check_settings(self)


def fit_equilibrium_model(
    lengths: Array,
    pressures: Array,
    settings: ModelSettings | None = None,
    *,
    max_pressure: float = bellows.MAX_PRESSURE,
    seed: int = 0,
) -> EquilibriumModel:
    """Fit a model to settled samples, as of the last one.

    Parameters
    ----------
    lengths : Settled lengths [m], shape (n, 9), in the order in which they were taken.
    pressures : Pressures that held them [Pa], shape (n, 9).
    settings : What is fitted; None takes the defaults.
    max_pressure : Upper end of the range of pressures [Pa].
    seed : Draws the hidden neurons.

    Raises
    ------
    EquilibriumModelError
        When the samples are too few, not finite, or do not move every bellows, or when no model
        keeps the constraints.
    """
    settings = settings or ModelSettings()
    count = len(lengths)
    check_samples(lengths, pressures)
    mean, scale = lengths.mean(axis=0), float(lengths.std(axis=0).mean())
    rng = np.random.default_rng(seed)
    hidden = draw_hidden_layer(
        settings.neurons, bellows.COUNT, settings.spread, rng, single=settings.single
    )
    penalties = Penalties(settings.ridge, settings.direct_ridge, 1e-2 if settings.trend else 1e9)
    low, high = ((np.full(9, end) - mean) / scale for end in LENGTHS)
    least = settings.min_slope * scale / max_pressure
    x, y = (lengths - mean) / scale, pressures / max_pressure
    times = (np.arange(count) - count + 1) / _TREND_SAMPLES

    def fitted(chosen: NDArray[np.bool_], error: float) -> tuple[EquilibriumModel, Array]:
        samples = x[chosen], y[chosen], times[chosen], hidden, penalties
        if settings.constrained:
            elm, trend = fit_rising_elm(*samples, low=low, high=high, least_slope=least)
        else:
            elm, trend = fit_elm(*samples)
        constrained = settings.constrained
        model = EquilibriumModel(mean, scale, elm, max_pressure, constrained, error, count)
        return model, max_pressure * trend

    squares, parts = 0.0, np.arange(count) % _FOLDS
    try:
        for part in range(_FOLDS):
            model, trend = fitted(parts != part, 0.0)
            for k in np.flatnonzero(parts == part):
                then = model.shifted(trend * times[k])
                squares += float(np.sum((then.pressures(lengths[k]) - pressures[k]) ** 2))
        return fitted(parts >= 0, float(np.sqrt(squares / pressures.size)))[0]
    except ConstraintError as error:
        raise EquilibriumModelError(f"no model keeps the constraints: {error}") from error


def check_samples(lengths: Array, pressures: Array) -> None:
    """Raise an EquilibriumModelError when samples are too few, not finite, or move too little."""
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
