"""What hours of use do to an equilibrium model, with and without the controller's adaptation."""

from __future__ import annotations

import numpy as np

from benchmarks.engine.experiment import Figures
from benchmarks.trunk.length_control_methods import LEARNED, controller
from benchmarks.trunk.length_responses import control, identified, new_plant
from bha_common import bellows
from bha_pressure_ctrl.length_controller import LengthController

_STEP = 8.0  # [s] for which a command is held
_PART = 0.5  # [h] over which errors are averaged


def age(seed: int, hours: float, samples: int) -> Figures:
    """Command random postures for hours, and compare models with the pressures that held them.

    Returns
    -------
    Ends of the parts of the time [h], and for the model as fitted and as adapted the root mean
    square error of its pressures over each part [kPa], at the lengths of settled postures.
    """
    plant = new_plant(seed)
    model, lengths = identified(plant, samples, seed)
    adapting = controller(LEARNED, model)
    assert isinstance(adapting, LengthController)
    rng = np.random.default_rng([seed, 3])
    times, fitted, adapted = [], [], []
    for end in np.arange(_PART, hours + 1e-9, _PART):
        errors = []
        for _ in range(round(3600.0 * _PART / _STEP)):
            # Commands that the model thinks typical; the robot is asked for lengths, not pressures.
            command = lengths[rng.integers(len(lengths))]
            middle = np.mean(lengths, axis=0)
            command = middle + 0.6 * (command - middle)
            known = adapting.model
            control(plant, adapting, command, _STEP - 1.0)
            applied = []
            measured = []
            for _ in range(50):
                applied.append(adapting.update(command, plant.state.lengths))
                measured.append(plant.step(applied[-1]).lengths)
            held, there = np.mean(applied, axis=0), np.mean(measured, axis=0)
            inside = (held > 0.0) & (held < bellows.MAX_PRESSURE)
            errors.append(
                [np.mean((each.pressures(there) - held)[inside] ** 2) for each in (model, known)]
            )
        times.append(float(end))
        rms = 1e-3 * np.sqrt(np.mean(errors, axis=0))
        fitted.append(float(rms[0]))
        adapted.append(float(rms[1]))
    rises = bool((adapting.model.lowest_slopes() > 0.0).all())
    return {"hours": times, "fitted": fitted, "adapted": adapted, "still rises": rises}
