"""What can be seen of the simulated robot, and what it remembers."""

from __future__ import annotations

from dataclasses import dataclass

from bha_sim.disturbances import Disturbances
from bha_sim.parameter_checks import Array
from bha_sim.pneumatics import PneumaticState
from bha_sim.potentiometers import PotentiometerState


@dataclass(frozen=True, slots=True, eq=False)
class PlantState:
    """What can be seen of the robot after a control period; all arrays are read-only.

    Attributes
    ----------
    time : Simulated time since the start [s].
    lengths : Bellows lengths as the potentiometers measure them [m], shape (9,).
    pressures : Pressures in the bellows as the sensors measure them [Pa], shape (9,).
    tip : Position of the tip in `bha_base` [m], shape (3,).
    tip_quaternion : Orientation of the tip in `bha_base`, x, y, z, w [-], shape (4,).
    true_lengths : Bellows lengths as they are [m], shape (9,).
    """

    time: float
    lengths: Array
    pressures: Array
    tip: Array
    tip_quaternion: Array
    true_lengths: Array


@dataclass(frozen=True, eq=False)
class PlantSnapshot:
    """Everything that a plant remembers, for `Plant.restore_state`; opaque, may be pickled."""

    ticks: int
    mechanics: Array
    viscoelastic: Array
    centres: Array
    pneumatics: PneumaticState
    potentiometers: PotentiometerState
    state: PlantState
    seed: int
    disturbances: Disturbances
