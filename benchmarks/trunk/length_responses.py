"""Steps, tracking and stability of a controller of the lengths, on one simulated robot.

Errors are those of the measured lengths without the noise and the steps of the reading: the true
lengths, moved by what the readings' mean over the last 3 s of a posture is off. So white noise
(0.5 mm) and quantisation (0.25 mm) count neither as overshoot nor as error, and what they make the
controller do, does.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from benchmarks.trunk.length_control_methods import PERIOD, Controller
from bha_common import bellows
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from bha_pressure_ctrl.identification import Identification, IdentificationSettings
from bha_pressure_ctrl.identified_model import fit_identified_model
from bha_sim.plant import Plant
from bha_sim.robot_parameters import draw_robot, load_parameters

Array = NDArray[np.float64]

TOLERANCE = 2e-3  # [m]
HOLD = 8.0  # [s] for which a step is watched
_TAIL = 150  # ticks over which a posture's mean is taken
_SWINGING = 1e-3  # [m] of standard deviation over 2 s; noise alone leaves below 0.4 mm


def new_plant(seed: int) -> Plant:
    """Make robot `seed`, vented and at rest."""
    return Plant(draw_robot(load_parameters(), seed), seed=seed, control_period=PERIOD)


def settled_samples(
    plant: Plant, count: int, seed: int, *, top: float = bellows.MAX_PRESSURE
) -> tuple[Array, Array, float]:
    """Take samples as `Identification` does, with pressures up to `top` [Pa].

    Returns
    -------
    Lengths [m] and pressures [Pa], both of shape (count, 9), and the robot time it took [s].
    """
    running = _identification(plant, IdentificationSettings(steps=0), count, seed, top)
    return *running.samples(), running.elapsed


def identified(plant: Plant, count: int, seed: int) -> tuple[EquilibriumModel, Array]:
    """Identify a robot as the controller does; return its model and the settled lengths [m]."""
    running = _identification(plant, IdentificationSettings(), count, seed, bellows.MAX_PRESSURE)
    model = fit_identified_model(running, period=PERIOD, seed=seed)
    return model, running.samples()[0]


def _identification(
    plant: Plant, settings: IdentificationSettings, count: int, seed: int, top: float
) -> Identification:
    running = Identification(
        settings,
        max_pressure=top,
        start=plant.state.pressures,
        period=PERIOD,
        seed=seed,
        samples=count,
    )
    while not running.done:
        plant.step(running.update(plant.state.lengths))
    return running


def reachable(plant: Plant, count: int, rng: np.random.Generator) -> list[Array]:
    """Return measured lengths of typical postures (middle half of the pressures) [m]; (9,) each."""
    found = []
    for _ in range(count):
        pressures = bellows.MAX_PRESSURE * rng.uniform(0.25, 0.75, 9)
        lengths = [plant.step(pressures).lengths for _ in range(round(9.0 / PERIOD))]
        found.append(np.mean(lengths[-50:], axis=0))
    return found


def control(plant: Plant, controller: Controller, command: Array, seconds: float) -> Array:
    """Hold a command [m]; return measured and true lengths [m], shape (ticks, 2, 9)."""
    seen = []
    for _ in range(round(seconds / PERIOD)):
        state = plant.step(controller.update(command, plant.state.lengths))
        seen.append((state.lengths, state.true_lengths))
    return np.array(seen)


def steps(plant: Plant, controller: Controller, targets: list[Array]) -> dict[str, list[float]]:
    """Go from target to target, and tell of each step how it went.

    Returns
    -------
    Each a number a step: time until all nine lengths stay within 2 mm, and until their root mean
    square error does [s]; largest overshoot of the nine and mean of the nine, of bellows that had
    5 mm or more to go [mm]; root mean square error over the second second [mm].
    """
    control(plant, controller, targets[0], 2.0 * HOLD)
    told: dict[str, list[float]] = {
        name: [] for name in ("all within", "rms within", "overshoot", "mean overshoot", "rms")
    }
    for before, target in itertools.pairwise(targets):
        measured, true = control(plant, controller, target, HOLD).transpose(1, 0, 2)
        error = true - target + (measured[-_TAIL:] - true[-_TAIL:]).mean(axis=0)
        told["all within"].append(_settling(np.abs(error).max(axis=1)))
        told["rms within"].append(_settling(np.sqrt(np.mean(error**2, axis=1))))
        way = target - before
        far = np.abs(way) >= 5e-3
        beyond = np.maximum((np.sign(way) * error).max(axis=0), 0.0)[far]
        told["overshoot"].append(1e3 * float(beyond.max(initial=0.0)))
        told["mean overshoot"].append(1e3 * float(beyond.mean()) if far.any() else 0.0)
        told["rms"].append(1e3 * float(np.sqrt(np.mean(error[50:100] ** 2))))
    return told


def tracking(plant: Plant, controller: Controller, targets: list[Array]) -> float:
    """Follow straight lines of 5 s between targets; root mean square error [mm].

    Of what is measured against what was commanded at the same time, without white noise.
    """
    squares = []
    offset = np.zeros(9)
    for before, target in itertools.pairwise(targets):
        for share in np.arange(1, 251) / 250.0:
            command = before + share * (target - before)
            state = plant.step(controller.update(command, plant.state.lengths))
            # What the readings are off is known from their mean; play and drift move slowly.
            offset += 0.02 * (state.lengths - state.true_lengths - offset)
            squares.append((state.true_lengths + offset - command) ** 2)
    return 1e3 * float(np.sqrt(np.mean(squares[250:])))


def resting(plant: Plant, controller: Controller, targets: list[Array]) -> float:
    """Return how far the tip moves about its mean once lengths are held [mm], root mean square."""
    squares = []
    for target in targets:
        control(plant, controller, target, HOLD + 4.0)
        tips = []
        for _ in range(round(10.0 / PERIOD)):
            tips.append(plant.step(controller.update(target, plant.state.lengths)).tip)
        squares.append(np.var(tips, axis=0).sum())
    return 1e3 * float(np.sqrt(np.mean(squares)))


def is_stable(plant: Plant, make: Callable[[], Controller], targets: list[Array]) -> bool:
    """Tell whether every target is held without swinging on, 8 s after the step."""
    controller = make()
    for target in targets:
        true = control(plant, controller, target, HOLD + 2.0)[-100:, 1]
        if np.std(true, axis=0).max() > _SWINGING:
            return False
    return True


def _settling(error: Array) -> float:
    """Return the time after which an error stays within tolerance [s]; HOLD if it never does."""
    return float((np.flatnonzero(error > TOLERANCE).max(initial=-1) + 1) * PERIOD)
