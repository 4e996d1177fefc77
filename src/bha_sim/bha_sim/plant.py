"""The simulated robot: pressures in, measured lengths and tip out, one control period at a time.

    plant = Plant(draw_robot(load_parameters(), seed=0), seed=0)
    state = plant.step(np.full(9, 5e4))

The same parameters, seed and pressures give the same bits: in one process or in several, after
`reset`, and after `restore_state`. What goes wrong with the robot is told it by `disturb`.
"""

from __future__ import annotations

import math

import numpy as np

from bha_common import bellows
from bha_sim.disturbances import Disturbances
from bha_sim.errors import PlantDivergedError
from bha_sim.mechanics import Mechanics
from bha_sim.parameter_checks import Array
from bha_sim.plant_state import PlantSnapshot, PlantState
from bha_sim.pneumatics import Pneumatics
from bha_sim.potentiometers import Potentiometers
from bha_sim.robot_parameters import RobotParameters
from bha_sim.visco_elasticity import ViscoElasticity


class Plant:
    """One simulated robot.

    Parameters
    ----------
    parameters : The robot, already drawn.
    seed : Seeds all noise and drift of the sensors.
    control_period : Time for which a command holds [s]; it is integrated in equal steps that are
        no longer than the robot's `max_time_step`.

    Raises
    ------
    ValueError
        When the control period is not positive.
    RobotParameterError
        When a robot of these parameters does not hang at rest.
    """

    def __init__(
        self, parameters: RobotParameters, *, seed: int, control_period: float = 0.02
    ) -> None:
        if not (math.isfinite(control_period) and control_period > 0.0):
            raise ValueError(f"control_period must be above 0 s, got {control_period}")
        self.parameters = parameters
        self.control_period = control_period
        self._max_pressure = parameters.pneumatics.max_pressure
        self._visco = ViscoElasticity(
            parameters.relaxation,
            parameters.hysteresis,
            parameters.trunk.discs_per_segment,
            control_period,
        )
        mechanics = Mechanics(parameters, self._visco.stiffness_factors, control_period)
        self._mechanics = mechanics
        # Held here too: a look-up fewer in every tick.
        self._extensions, self._centres = mechanics.extensions, mechanics.centres
        self._lengths = mechanics.lengths
        self._disturbances = Disturbances()
        self._ticks = 0
        self._diverged = ""
        mechanics.come_to_rest(lambda: self._visco.relax(self._extensions, self._centres))
        self._rest = mechanics.state

        self._seed = seed
        pneumatic_seed, sensor_seed = np.random.SeedSequence(seed).spawn(2)
        self._pneumatics = Pneumatics(parameters.pneumatics, control_period, pneumatic_seed)
        self._potentiometers = Potentiometers(
            parameters.potentiometers, control_period, sensor_seed, self._lengths
        )
        self._state = self._observe()

    @property
    def state(self) -> PlantState:
        """The state after the last step, or before the first: vented and at rest."""
        return self._state

    @property
    def disturbances(self) -> Disturbances:
        """What is wrong with the robot now."""
        return self._disturbances

    def disturb(self, disturbances: Disturbances) -> None:
        """Let something go wrong from the next step on, instead of what was wrong before.

        ``Disturbances()`` takes everything back. It holds through `reset`, and until then; a
        snapshot brings back those that held when it was taken.
        """
        self._pneumatics.disturb(disturbances)
        self._potentiometers.disturb(disturbances)
        self._disturbances = disturbances
        self._mechanics.disturb(disturbances)

    def step(self, pressures: Array) -> PlantState:
        """Apply pressures for one control period.

        Parameters
        ----------
        pressures : Commanded pressures [Pa], shape (9,); clipped to the valid range.

        Raises
        ------
        ValueError
            When the pressures are not nine finite numbers; nothing has changed then.
        PlantDivergedError
            When the motion diverged; the plant must be reset or restored.
        """
        command = np.asarray(pressures, dtype=np.float64)
        if command.shape != (bellows.COUNT,):
            raise ValueError(f"pressures must have shape (9,), got {command.shape}")
        if not np.isfinite(command).all():
            raise ValueError(f"pressures must be finite, got {command}")
        if self._diverged:
            raise PlantDivergedError(f"{self._diverged}; reset or restore the plant to go on")
        command = np.minimum(np.maximum(command, 0.0), self._max_pressure)
        self._mechanics.pressures[:] = self._pneumatics.step(command)
        self._visco.update(self._extensions, self._centres)
        self._mechanics.integrate()
        self._ticks += 1
        self._guard()
        self._state = self._observe()
        return self._state

    def reset(self, seed: int | None = None) -> PlantState:
        """Start anew: vented, at rest, without memory.

        What was wrong with the robot stays wrong: it hangs as the sound one does at rest, and its
        disturbances act from the next step on; a drift begins at 0, a stuck valve is stuck vented.

        Parameters
        ----------
        seed : Seeds the noise; None takes the same seed again.
        """
        self._seed = self._seed if seed is None else seed
        self._mechanics.load(self._rest)
        self._diverged = ""
        self._visco.relax(self._extensions, self._centres)
        pneumatic_seed, sensor_seed = np.random.SeedSequence(self._seed).spawn(2)
        self._pneumatics.reset(pneumatic_seed)
        self._potentiometers.reset(sensor_seed, self._lengths)
        self._ticks = 0
        self._state = self._observe()
        return self._state

    def save_state(self) -> PlantSnapshot:
        """Take a snapshot from which `restore_state` continues exactly, noise included."""
        return PlantSnapshot(
            ticks=self._ticks,
            mechanics=self._mechanics.state,
            viscoelastic=self._visco.state,
            centres=self._centres.copy(),
            pneumatics=self._pneumatics.state,
            potentiometers=self._potentiometers.state,
            state=self._state,
            seed=self._seed,
            disturbances=self._disturbances,
        )

    def restore_state(self, snapshot: PlantSnapshot) -> PlantState:
        """Go back to a snapshot of a plant with the same parameters and control period."""
        self.disturb(snapshot.disturbances)
        self._mechanics.load(snapshot.mechanics)
        self._diverged = ""
        self._visco.state = snapshot.viscoelastic
        self._centres[:] = snapshot.centres
        self._pneumatics.state = snapshot.pneumatics
        self._potentiometers.state = snapshot.potentiometers
        self._ticks = snapshot.ticks
        self._seed = snapshot.seed
        self._state = snapshot.state
        return self._state

    def _guard(self) -> None:
        """Stop with a reason when the motion diverged."""
        if reason := self._mechanics.diverged:
            time = self._ticks * self.control_period
            self._diverged = f"the plant diverged at {time:.2f} s: {reason}"
            raise PlantDivergedError(self._diverged)

    def _observe(self) -> PlantState:
        # One block for all arrays: made read-only once, shared by five views.
        block = np.empty(34)
        self._potentiometers.measure(self._lengths, block[0:9])
        self._pneumatics.measure(block[9:18])
        block[18:27] = self._lengths
        block[27:30] = self._mechanics.tip
        block[30:33] = self._mechanics.tip_quaternion[1:]
        block[33] = self._mechanics.tip_quaternion[0]
        block.setflags(write=False)
        return PlantState(
            time=self._ticks * self.control_period,
            lengths=block[0:9],
            pressures=block[9:18],
            true_lengths=block[18:27],
            tip=block[27:30],
            tip_quaternion=block[30:34],
        )
