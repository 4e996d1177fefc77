"""A tip servo that knows the robot, for measuring what the robot can reach.

It is no controller of the project: it sees the true tip and the plant's parameters. Quasi-static
resolved-rate steps on the pressures, with the Jacobian of constant-curvature kinematics, only the
bellows that are not held at an end of their range, and the rest of the freedom drawn to mid-range.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from bha_sim.constant_curvature import tip_pose
from bha_sim.plant import Plant
from bha_sim.plant_state import PlantState

Array = NDArray[np.float64]

_DAMPING = 0.02  # [m] per 1: keeps steps small along the stiff direction
_DIFFERENCE = 1e-5  # [m]


class TipServo:
    """Drives the tip of a plant to goals.

    Parameters
    ----------
    plant : The plant.
    period : Time between two steps of the pressures [s].
    gain : Share of the tip error that one step is to remove [-].
    """

    def __init__(self, plant: Plant, *, period: float = 0.5, gain: float = 0.35) -> None:
        self._plant = plant
        self._ticks = round(period / plant.control_period)
        self._gain = gain
        parameters = plant.parameters
        self._radii = parameters.trunk.bellows_radii
        self._tool = parameters.trunk.tool_length
        self._top = parameters.pneumatics.max_pressure
        # Metres a pascal; creep and hysteresis make the bellows stiffer at first.
        self._compliance = parameters.bellows.areas / (1.8 * parameters.bellows.stiffness)
        self.pressures: Array = np.full(9, 0.5 * self._top)

    def reach(self, goal: Array, *, patience: float, tolerance: float) -> tuple[float, PlantState]:
        """Go to a goal, until it is held within `tolerance` or `patience` is over.

        Parameters
        ----------
        goal : Goal of the tip [m], shape (3,).
        patience : Longest time [s].
        tolerance : Error that counts as reached [m].

        Returns
        -------
        Smallest error [m] that was not exceeded for two seconds, and the last state.
        """
        state = self._plant.state
        errors: list[float] = []
        best = np.inf
        held = math.ceil(2.0 / (self._ticks * self._plant.control_period))
        for _ in range(int(patience / (self._ticks * self._plant.control_period))):
            for _ in range(self._ticks):
                state = self._plant.step(self.pressures)
            error = goal - state.tip
            errors.append(float(np.linalg.norm(error)))
            if len(errors) >= held:
                best = min(best, max(errors[-held:]))
            if best < tolerance:
                break
            self._move(self._gain * error, state.true_lengths)
        return best, state

    def bend_towards(self, goal: Array) -> None:
        """Set pressures that bend all segments alike towards a goal [m], shape (3,).

        From a posture that others left behind the servo may end in a corner of the pressures from
        which no small step leads on; from a plain arc it does not.
        """
        polar = np.arccos(goal[2] / np.linalg.norm(goal))
        azimuth = np.arctan2(goal[1], goal[0])
        away = -np.cos(np.tile(np.arange(3) * 2.0 * np.pi / 3.0, 3) - azimuth)
        self.pressures = np.clip(0.3 + 0.4 * polar * away, 0.0, 1.0) * self._top

    def _move(self, step: Array, lengths: Array) -> None:
        jacobian = self._jacobian(lengths) * self._compliance
        free = np.ones(9, dtype=bool)
        drift = 0.05 * (0.5 * self._top - self.pressures)
        for _ in range(9):
            part = np.where(free, jacobian, 0.0) / self._compliance
            square = part @ part.T + _DAMPING * np.eye(3)
            inverse = part.T @ np.linalg.inv(square) / self._compliance[:, None]
            change = inverse @ step
            rest = np.where(free, drift, 0.0)
            change += rest - inverse @ (jacobian @ rest)
            wanted = self.pressures + np.where(free, change, 0.0)
            out = free & ((wanted < 0.0) | (wanted > self._top))
            if not out.any():
                break
            # Hold at the end what would leave the range, and solve again with the others.
            self.pressures[out] = np.clip(wanted[out], 0.0, self._top)
            free &= ~out
        self.pressures = np.clip(wanted, 0.0, self._top)

    def _jacobian(self, lengths: Array) -> Array:
        moved = lengths + _DIFFERENCE * np.vstack([np.eye(9), -np.eye(9)])
        tips, _ = tip_pose(moved, self._radii, self._tool)
        return (tips[:9] - tips[9:]).T / (2.0 * _DIFFERENCE)
