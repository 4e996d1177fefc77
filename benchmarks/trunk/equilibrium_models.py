"""Equilibrium models on few and many settled samples: their errors, and what they violate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchmarks.engine.experiment import Figures
from benchmarks.trunk.length_responses import new_plant, settled_samples
from bha_common import bellows
from bha_pressure_ctrl.equilibrium_model import LENGTHS, EquilibriumModel
from bha_pressure_ctrl.model_fitting import ModelSettings, fit_equilibrium_model

Array = NDArray[np.float64]

LINEAR, USUAL = "linear", "unconstrained ELM"
FREE, CONSTRAINED = "the same, unconstrained", "constrained ELM"

MODELS = {
    LINEAR: ModelSettings(neurons=0, constrained=False, trend=False),
    # As it is mostly used: weights of +-1 on inputs of unit size, and no direct links.
    USUAL: ModelSettings(constrained=False, direct_ridge=1e6, spread=1.73, single=0.0, trend=False),
    FREE: ModelSettings(constrained=False),
    CONSTRAINED: ModelSettings(),
}
THIRD = "60 of a third"
_HELD_OUT = 20
_PROBES = 20_000


def compare(seed: int, counts: list[int]) -> Figures:
    """Fit every model to the first samples of one robot, and to samples from a third of the box.

    Held-out samples are taken right after the last one that was fitted to, so that both are of one
    age. Those of a third come from pressures in the lowest third of the range; held out are, there
    too, samples from all of it.
    """
    plant = new_plant(seed)
    told: Figures = {}
    lengths, pressures = np.empty((0, 9)), np.empty((0, 9))
    fresh = plant.save_state()
    for count in counts:
        # The sequence of postures is that of one long identification, cut into pieces.
        plant.restore_state(fresh)
        lengths, pressures, elapsed = settled_samples(plant, count, seed)
        held_out = settled_samples(plant, _HELD_OUT, seed + 500_000)[:2]
        told[str(count)] = {"time": elapsed, **_fits(lengths, pressures, held_out, seed)}
    plant.restore_state(fresh)
    top = bellows.MAX_PRESSURE / 3.0
    lengths, pressures, elapsed = settled_samples(plant, 60, seed, top=top)
    held_out = settled_samples(plant, _HELD_OUT, seed + 500_000)[:2]
    told[THIRD] = {"time": elapsed, **_fits(lengths, pressures, held_out, seed)}
    return told


def violations(model: EquilibriumModel, seed: int) -> dict[str, float]:
    """Look for what is violated anywhere in the box of lengths that can be commanded.

    Returns
    -------
    Share of places where a pressure does not rise with its own length, and where one is out of its
    range [%]; the lowest slope found [kPa/mm], and the one below which none is, for certain.
    """
    rng = np.random.default_rng([seed, 7])
    half = (_PROBES // 2, 9)
    places = np.vstack([rng.uniform(*LENGTHS, half), rng.choice(LENGTHS, half)])
    own = np.diagonal(model.slopes(places), axis1=1, axis2=2)
    pressures = model.pressures(places)
    outside = (pressures < 0.0) | (pressures > model.max_pressure)
    return {
        "falling": 1e2 * float(np.mean((own <= 0.0).any(axis=1))),
        "outside": 1e2 * float(np.mean(outside.any(axis=1))),
        "lowest": 1e-6 * float(own.min()),
        "certain": 1e-6 * float(model.lowest_slopes().min()),
    }


def _fits(lengths: Array, pressures: Array, held_out: tuple[Array, Array], seed: int) -> Figures:
    told: Figures = {}
    for name, settings in MODELS.items():
        model = fit_equilibrium_model(lengths, pressures, settings, seed=seed)
        errors = model.pressures(held_out[0]) - held_out[1]
        told[name] = {
            "error": 1e-3 * float(np.sqrt(np.mean(errors**2))),
            **violations(model, seed),
        }
    return told
