"""What pneumatics and potentiometers do to a command and a length, seen from outside."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.trunk.plant_drives import Array, hold, hold_all, top
from bha_sim.plant import Plant

Figures = dict[str, Any]

_SEEN = 2000.0  # [Pa] a rise that is no noise
_LAG = 1.0 - np.exp(-1.0)


def pneumatics(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Dead time and lags of steps of all pressures, and the play of the regulators."""
    dead, fill = _step(plant, 0.0, 0.8 * top(plant))
    _, vent = _step(plant, 0.8 * top(plant), 0.2 * top(plant))
    middle = 0.5 * top(plant)
    hold(plant, np.zeros(9), 10.0)
    risen = _mean_pressures(plant, np.full(9, middle))
    hold(plant, np.full(9, top(plant)), 10.0)
    fallen = _mean_pressures(plant, np.full(9, middle))
    return {
        "dead time [s]": float(np.mean(dead)),
        "lag of filling [s]": float(np.mean(fill)),
        "lag of venting [s]": float(np.mean(vent)),
        "play of the regulators [Pa]": float(np.mean(fallen - risen)),
    }


def potentiometers(plant: Plant, rng: np.random.Generator, scale: float) -> Figures:
    """Noise, steps and drift of the readings at rest for an hour, then play, offset and gain."""
    duration = 60.0 * max(2, round(60 * scale))
    readings = np.array([state.lengths for state in hold_all(plant, np.zeros(9), duration)])
    minutes = readings.reshape(-1, round(60.0 / plant.control_period), 9).mean(axis=1)
    values = np.unique(readings[:1000])
    states = hold_all(plant, np.full(9, 0.8 * top(plant)), 20.0)
    risen = np.mean([state.lengths - state.true_lengths for state in states[-250:]], axis=0)
    hold(plant, np.full(9, top(plant)), 10.0)
    states = hold_all(plant, np.full(9, 0.6 * top(plant)), 20.0)
    fallen = np.mean([state.lengths - state.true_lengths for state in states[-250:]], axis=0)
    return {
        "noise [m]": float(np.std(np.diff(readings, axis=0)) / np.sqrt(2.0)),
        "step [m]": float(np.diff(values)[np.diff(values) > 1e-7].min()),
        "drift in an hour [m]": float(np.mean(np.ptp(minutes, axis=0))),
        "play [m]": float(np.mean(fallen - risen)),
        "offsets [m]": (0.5 * (fallen + risen)).tolist(),
    }


def _step(plant: Plant, before: float, after: float) -> tuple[Array, Array]:
    """Dead time and time to 63 % after it of a step of all pressures [Pa]; each [s], shape (9,)."""
    hold(plant, np.full(9, before), 5.0)
    pressures = np.array([state.pressures for state in hold_all(plant, np.full(9, after), 5.0)])
    ticks = np.arange(len(pressures))[:, None]
    moved = np.abs(pressures - before)
    begun = np.argmax((moved > _SEEN) & (ticks > 0), axis=0)
    there = np.argmax(moved >= _LAG * abs(after - before), axis=0)
    return begun * plant.control_period, (there - begun + 1) * plant.control_period


def _mean_pressures(plant: Plant, command: Array) -> Array:
    """Measured pressures [Pa], shape (9,), once a command has settled."""
    states = hold_all(plant, command, 10.0)
    pressures: Array = np.mean([state.pressures for state in states[-250:]], axis=0)
    return pressures
