"""The part of the disturbances that is mechanical, put into a running MuJoCo model.

A softened bellows loses the same share of its lasting spring, creep, friction and damping; the
cubic hardening stays, since it is the end of the folds' geometry. A payload is a point mass.
"""

from __future__ import annotations

import mujoco
import numpy as np

from bha_common import bellows
from bha_sim.disturbances import Disturbances
from bha_sim.mujoco_model import TrunkModel


class DisturbedModel:
    """Changes a compiled model, and knows it as it was.

    Parameters
    ----------
    trunk : The sound model.
    """

    def __init__(self, trunk: TrunkModel) -> None:
        model = self._model = trunk.model
        self._pieces, self._tip_body = trunk.pieces, trunk.tip_body
        self._stiffness = model.tendon_stiffness[trunk.pieces].copy()
        self._damping = model.tendon_damping[trunk.pieces].copy()
        self._now = self._mechanical(Disturbances())

    def apply(self, disturbances: Disturbances) -> bool:
        """Make the model that of a disturbed robot.

        Returns
        -------
        Whether anything has changed. What MuJoCo has computed of its data is out of date then.
        """
        before, self._now = self._now, self._mechanical(disturbances)
        if self._now == before:
            return False
        left = 1.0 - np.repeat(disturbances.softening, len(self._stiffness) // bellows.COUNT)
        self._model.tendon_stiffness[self._pieces] = self._stiffness * left
        self._model.tendon_damping[self._pieces] = self._damping * left
        self._model.body_mass[self._tip_body] = disturbances.payload
        # Masses of subtrees and the like follow from masses. It needs data of its own to work in.
        mujoco.mj_setConst(self._model, mujoco.MjData(self._model))
        return True

    @staticmethod
    def _mechanical(disturbances: Disturbances) -> tuple[float, tuple[float, ...]]:
        return disturbances.payload, disturbances.softening
