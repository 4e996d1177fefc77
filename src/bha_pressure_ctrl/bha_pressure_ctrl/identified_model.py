"""Makes a model of all that identification has seen of a robot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bha_common import bellows
from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics
from bha_pressure_ctrl.bellows_memory import (
    BellowsMemory,
    fit_memory,
    friction_in_control,
)
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from bha_pressure_ctrl.identification import Identification
from bha_pressure_ctrl.inertia import fit_inertia
from bha_pressure_ctrl.model_fitting import ModelSettings, check_samples, fit_equilibrium_model
from bha_pressure_ctrl.pressure_steps import PressureSteps
from bha_pressure_ctrl.step_response import fit_step_response

Array = NDArray[np.float64]

_BEFORE = 0.5  # [s] before a step, whose mean is where it begins


def fit_identified_model(
    identification: Identification,
    settings: ModelSettings | None = None,
    *,
    period: float,
    max_pressure: float = bellows.MAX_PRESSURE,
    seed: int = 0,
) -> EquilibriumModel:
    """Fit what the bellows remember, how they lag, and of the rest the equilibrium.

    Parameters
    ----------
    identification : With its samples collected.
    settings, max_pressure, seed : As for `fit_equilibrium_model`.
    period : Time between two updates of the identification [s].

    Raises
    ------
    EquilibriumModelError
        When the samples make no model.
    """
    lengths, pressures = identification.samples()
    check_samples(lengths, pressures)
    records = identification.records()
    memory = fit_memory(records.lengths, records.pressures, records.states, records.times)
    remembered = (memory * records.states[records.settled]).sum(axis=1)
    model = fit_equilibrium_model(
        lengths, pressures - remembered, settings, max_pressure=max_pressure, seed=seed
    )
    dynamics = BellowsDynamics(memory)
    if identification.steps is not None:
        dynamics = _with_lags(model, dynamics, identification.steps, period)
    if dynamics.fill_lag > 0.0:
        motion, asked, states = identification.motion()
        held = model.pressures(motion) + (memory * states).sum(axis=1)
        inertia = fit_inertia(motion, asked, held, dynamics, period)
        dynamics = replace(dynamics, inertia=inertia)
    dynamics = replace(dynamics, memory=friction_in_control(memory))
    return replace(model, dynamics=dynamics)


def _with_lags(
    model: EquilibriumModel, dynamics: BellowsDynamics, steps: PressureSteps, period: float
) -> BellowsDynamics:
    """Read dead time and lags from steps, which alternate and go up first; the same if in vain."""
    lengths, asked = steps.seen()
    if len(lengths) < 3:
        return dynamics
    memory = BellowsMemory(lengths[0, 0], period)
    states = np.array([memory.update(each) for each in lengths.reshape(-1, bellows.COUNT)])
    held = model.pressures(lengths) + (dynamics.memory * states).sum(axis=1).reshape(lengths.shape)
    ways = (asked[1:] - asked[:-1])[:, :1]
    after = held[1:] / ways
    before = held[:-1, -round(_BEFORE / period) :].mean(axis=1) / ways[:, 0]
    up, down = (fit_step_response(before[k::2], after[k::2], period) for k in (0, 1))
    if up is None or down is None:
        return dynamics
    return replace(
        dynamics,
        dead_time=0.5 * (up[0] + down[0]),
        fill_lag=up[1],
        vent_lag=down[1],
        response_lag=0.0,
    )
