"""What the sensors of the actions are off by just now, seen in outcomes that come out elsewhere.

Cables stretch and slip, so a reading q is the true action plus an offset b that wanders. A forward
model that has seen many offsets knows their mean; what it then misses tells of today's:

    b_t = rho b_{t-1} + noise,   rho = exp(-1 / samples),   spread s at all times
    x_t - f(q_t - b) = -J b + noise,   J = df/dq

This is a Kalman filter for an Ornstein-Uhlenbeck process. An outcome has fewer entries than an
action, but J turns as the robot moves, so in time every offset shows.
"""

import math

import numpy as np

from bha_goal_babbling.arrays import FloatArray, matrix, vector
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState


class SensorOffsets:
    """Follows the offsets of the readings of the actions.

    Parameters
    ----------
    size : int
        Number m of entries of an action.
    spread : float
        Standard deviation s of an offset, in the unit of actions; 0 for sensors without any.
    samples : float
        Examples in which an offset changes by about its spread.
    """

    def __init__(self, size: int, spread: float, samples: float) -> None:
        self._spread = spread
        self._samples = samples
        self._offsets = np.zeros(size)
        self._covariance = spread**2 * np.eye(size)

    @property
    def values(self) -> FloatArray:
        """Readings less actions, shape (m,)."""
        return self._offsets

    def learn(self, jacobian: FloatArray, missed: FloatArray, variance: float) -> None:
        """Learn from an example.

        Parameters
        ----------
        jacobian : array
            df/dq at the example, shape (n, m).
        missed : array
            Its outcome less the one that was expected with the present offsets, shape (n,).
        variance : float
            Variance of an entry of the outcome that comes from elsewhere.
        """
        if self._spread == 0.0:
            return
        rho = math.exp(-1.0 / self._samples)
        self._offsets = rho * self._offsets
        covariance = rho**2 * self._covariance
        covariance += (1.0 - rho**2) * self._spread**2 * np.eye(len(covariance))
        seen = jacobian @ covariance
        innovation = seen @ jacobian.T + variance * np.eye(missed.size)
        gain = np.linalg.solve(innovation, seen).T
        self._offsets = self._offsets - gain @ missed
        covariance = covariance - gain @ seen
        self._covariance = 0.5 * (covariance + covariance.T)

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {"values": self._offsets, "covariance": self._covariance}
        return SavedState(arrays, {"spread": self._spread, "samples": self._samples})

    @classmethod
    def restore(cls, state: SavedState) -> "SensorOffsets":
        """Return the offsets whose snapshot this is; they continue bit for bit.

        Raises
        ------
        InvalidConfigError, InvalidArrayError
            If the arrays do not fit together.
        """
        values = vector("values", state.arrays["values"])
        covariance = matrix("covariance", state.arrays["covariance"], values.size)
        if covariance.shape != (values.size, values.size):
            raise InvalidConfigError(
                f"{values.size} offsets have a covariance of shape {covariance.shape}"
            )
        settings = state.settings
        offsets = cls(values.size, float(settings["spread"]), float(settings["samples"]))
        offsets._offsets, offsets._covariance = values, covariance
        return offsets
