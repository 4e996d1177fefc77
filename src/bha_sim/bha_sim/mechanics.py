"""The trunk in MuJoCo: pressures and the centres of its springs in, its motion out."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np

from bha_sim.disturbances import Disturbances
from bha_sim.disturbed_model import DisturbedModel
from bha_sim.divergence import why_diverged
from bha_sim.errors import RobotParameterError
from bha_sim.mujoco_model import build_model
from bha_sim.parameter_checks import Array
from bha_sim.robot_parameters import RobotParameters

_STATE = mujoco.mjtState.mjSTATE_INTEGRATION
_REST_SPEED = 1e-9  # [m/s] and [rad/s]
_REST_TIME = 120.0  # [s]


class Mechanics:
    """Masses, springs and torsion of one robot.

    The arrays are views into MuJoCo's own memory, read and written every tick without a look-up.

    Parameters
    ----------
    parameters : The robot, already drawn.
    stiffness_factors : As of `build_model`, shape (pieces,); a piece is a bellows within a disc.
    control_period : Time for which pressures hold [s]; it is integrated in equal steps that are no
        longer than the robot's `max_time_step`.

    Attributes
    ----------
    model, data : MuJoCo's own.
    pressures : What the bellows are under [Pa], shape (9,); written before `integrate`.
    centres : Extension at which each piece is without force [m], shape (pieces,); as `pressures`.
    extensions : Extension of each piece [m], shape (pieces,).
    lengths : Length of each bellows [m], shape (9,).
    tip, tip_quaternion : Position [m], shape (3,), and orientation (w, x, y, z) of the tip.
    """

    def __init__(
        self, parameters: RobotParameters, stiffness_factors: Array, control_period: float
    ) -> None:
        # A little slack, so that rounding does not cost a step.
        steps = max(1, math.ceil(control_period / parameters.max_time_step - 1e-9))
        self._parameters = parameters
        self._control_period = control_period
        self._steps = steps
        trunk = build_model(parameters, stiffness_factors, control_period / steps)
        self.model, self.data = trunk.model, mujoco.MjData(trunk.model)
        self._disturbed = DisturbedModel(trunk)
        self.pressures = self.data.ctrl
        self.extensions = self.data.ten_length[trunk.pieces]
        self.lengths = self.data.ten_length[trunk.bellows]
        self.tip = self.data.xpos[trunk.tip_body]
        self.tip_quaternion = self.data.xquat[trunk.tip_body]
        self._spring_range = self.model.tendon_lengthspring[trunk.pieces]
        self.centres = np.zeros(len(self.extensions))
        self._centre_column = self.centres[:, None]

    @property
    def state(self) -> Array:
        """Everything MuJoCo needs to go on exactly; given back to `load`."""
        state = np.empty(mujoco.mj_stateSize(self.model, _STATE))
        mujoco.mj_getState(self.model, self.data, state, _STATE)
        return state

    @property
    def diverged(self) -> str:
        """Why the motion is no motion any more; empty while it is one.

        MuJoCo checks all positions and velocities itself, and warns.
        """
        if np.count_nonzero(self.data.warning.number):
            return why_diverged(self.model, self.data)
        return ""

    def disturb(self, disturbances: Disturbances) -> None:
        """Let something be wrong with the masses or stiffnesses from the next step on."""
        if self._disturbed.apply(disturbances):
            # The mass matrix of the next step is computed already: again, with the new mass.
            mujoco.mj_step1(self.model, self.data)

    def integrate(self) -> None:
        """Advance by a control period; positions and velocities are evaluated at its end."""
        self._spring_range[:] = self._centre_column
        model, data = self.model, self.data
        # The springs' centres and the pressures are new: passive forces first, the rest follows.
        mujoco.mj_passive(model, data)
        mujoco.mj_step2(model, data)
        if self._steps > 1:
            mujoco.mj_step(model, data, nstep=self._steps - 1)
        mujoco.mj_step1(model, data)

    def load(self, state: Array) -> None:
        """Go back to a `state`, and forget every warning."""
        mujoco.mj_setState(self.model, self.data, state, _STATE)
        for warning in self.data.warning:
            warning.number = 0
        mujoco.mj_step1(self.model, self.data)

    def come_to_rest(self, relax: Callable[[], None]) -> None:
        """Hang vented until nothing moves.

        Parameters
        ----------
        relax : Lets all creep and hysteresis go, from the extensions to the centres.

        Raises
        ------
        RobotParameterError
            When the trunk does not hang at rest.
        """
        mujoco.mj_step1(self.model, self.data)
        for _ in range(math.ceil(_REST_TIME / self._control_period)):
            relax()
            self.integrate()
            if reason := self.diverged:
                raise RobotParameterError(f"the vented trunk does not hang at rest: {reason}")
            if np.abs(self.data.qvel).max() < _REST_SPEED:
                break
        else:
            raise RobotParameterError(
                f"the vented trunk still moves after {_REST_TIME:g} s: trunk.damping_time "
                f"({self._parameters.trunk.damping_time:g} s) is too small or too large"
            )
        self.data.qvel[:] = 0.0
        self.data.time = 0.0
        mujoco.mj_step1(self.model, self.data)
        relax()
