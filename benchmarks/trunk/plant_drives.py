"""What the measurements do with a plant: hold pressures, control lengths, look at the tip."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bha_sim.constant_curvature import tip_pose
from bha_sim.plant import Plant
from bha_sim.plant_state import PlantState

Array = NDArray[np.float64]


def task_grid() -> Array:
    """Goals of the CoR-Lab toolkit's task grid [m], shape (315, 3)."""
    goals = []
    for radius in (0.735, 0.78, 0.825):
        for polar in np.radians(np.linspace(5.14, 36.0, 7)):
            for azimuth in np.arange(15) * 2.0 * np.pi / 15.0:
                goals.append(
                    [
                        radius * np.sin(polar) * np.cos(azimuth),
                        radius * np.sin(polar) * np.sin(azimuth),
                        radius * np.cos(polar),
                    ]
                )
    return np.array(goals)


def top(plant: Plant) -> float:
    """Highest pressure of the plant [Pa]."""
    return plant.parameters.pneumatics.max_pressure


def typical(plant: Plant, rng: np.random.Generator) -> Array:
    """Draw a typical posture: pressures in the middle half of the range [Pa], shape (9,)."""
    return top(plant) * rng.uniform(0.25, 0.75, 9)


def hold(plant: Plant, pressures: Array, duration: float) -> PlantState:
    """Hold pressures [Pa] for a duration [s]; the last state."""
    return hold_all(plant, pressures, duration)[-1]


def hold_all(plant: Plant, pressures: Array, duration: float) -> list[PlantState]:
    """Hold pressures [Pa] for a duration [s]; all states."""
    return [plant.step(pressures) for _ in range(round(duration / plant.control_period))]


def control_lengths(
    plant: Plant, target: Array, pressures: Array, duration: float
) -> list[PlantState]:
    """Bring the measured lengths to a target by integrating control; the last states."""
    integral = pressures.copy()
    states = [plant.state]
    for _ in range(round(duration / plant.control_period)):
        error = target - states[-1].lengths
        integral += 1e6 * error * plant.control_period
        np.clip(integral, 0.0, top(plant), out=integral)
        states.append(plant.step(integral + 3e5 * error))
    return states


def range_ends(plant: Plant) -> Array:
    """Shortest and longest true length of each bellows [m], shape (2, 9)."""
    ends = np.empty((2, 9))
    for row, pressure in enumerate((0.0, top(plant))):
        for index in range(9):
            pressures = np.full(9, 0.5 * top(plant))
            pressures[index] = pressure
            ends[row, index] = hold(plant, pressures, 10.0).true_lengths[index]
    return ends


def constant_curvature(plant: Plant, state: PlantState) -> tuple[Array, Array]:
    """Tip [m] and rotation by constant-curvature kinematics on the true lengths."""
    trunk = plant.parameters.trunk
    return tip_pose(state.true_lengths, trunk.bellows_radii, trunk.tool_length)


def twist_angle(plant: Plant, state: PlantState) -> float:
    """Turn about its own axis of the tip against constant curvature [rad]."""
    x, y, z, w = state.tip_quaternion
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    relative = constant_curvature(plant, state)[1].T @ turned
    return float(np.arctan2(relative[1, 0] - relative[0, 1], relative[0, 0] + relative[1, 1]))
