"""A forward model x = f(q), learned from the examples that goal babbling makes on its way.

    x_t = W' [phi(z_t); q_t - q_{t-1}; q_t - 2 q_{t-1} + q_{t-2}],    z = q - q_home

phi holds every product of up to three entries of z, so f is a polynomial of third degree: enough
for a trunk that bends by a radian, and smooth beyond the examples. The last two groups stand for
the outcome that lags behind a robot under way; at rest they are zero. W is found by recursive
least squares with a prior (Ljung and Soderstrom, "Theory and practice of recursive
identification", 1983), a Kalman filter whose process noise keeps it from falling asleep:

    gain         k_t = P_t a_t / (r + a_t' P_t a_t),   a_t the bracket above
    parameters   W <- W + k_t (x_t - W' a_t)'
    covariance   P <- P - k_t (P_t a_t)' + (r / memory^2) I

It is exact only on the thin sheet of actions that was explored, which is where it is asked: as in
the forward models of Jamone and others that the article names beside goal babbling (section 3).
"""

import math
from itertools import combinations_with_replacement
from typing import Any

import numba
import numpy as np

from bha_goal_babbling.arrays import FloatArray, matrix, matrix_or_empty, vector
from bha_goal_babbling.errors import InvalidConfigError
from bha_goal_babbling.saved_state import SavedState

_DEGREE = 3
_PRIOR = np.array([2.0, 2.0, 1.0, 0.5])
"""Standard deviation of a parameter at first, by the degree of its feature, in scaled units: slopes
of the trunk are 0.3 to 2.2. What bends is taken to be less, so that the few examples of the first
minutes are not continued beyond by a third degree that nothing has shown."""
_MEMORY = 300.0
"""Examples that a feature of size 1 is averaged over in the long run; smaller ones over more."""


class ForwardModel:
    """Predicts outcomes of actions, with the slope and the variance of the prediction.

    Parameters
    ----------
    home_action, home_outcome : array
        Where it is expanded, shapes (m,) and (n,): at first it says home_outcome everywhere.
    noise : float
        Standard deviation of an entry of the outcome that no action explains, in the unit of
        outcomes.
    """

    def __init__(self, home_action: FloatArray, home_outcome: FloatArray, noise: float) -> None:
        m, n = home_action.size, home_outcome.size
        self._home = home_action.copy()
        self._variance = noise**2
        self._factors = _factors(m)
        polynomial = len(self._factors)
        self._parameters = np.zeros((polynomial + 2 * m, n))
        self._parameters[0] = home_outcome
        degrees = np.append(np.count_nonzero(self._factors < m, axis=1), [1] * (2 * m))
        self._covariance = np.diag(_PRIOR[degrees] ** 2)
        self._history = np.zeros((0, m))  # the last two actions, the newest first

    @property
    def variance(self) -> float:
        """Variance of an entry of the outcome that no action explains."""
        return self._variance

    def predict(self, action: FloatArray) -> FloatArray:
        """Return the outcome, shape (n,), of holding an action, shape (m,)."""
        features = np.empty(len(self._factors))
        _features(action - self._home, self._factors, features)
        outcome: FloatArray = features @ self._parameters[: features.size]
        return outcome

    def jacobian(self, action: FloatArray) -> FloatArray:
        """Return df/dq at an action, shape (m,), as shape (n, m)."""
        slopes = self._slopes(action)
        slope: FloatArray = self._parameters[: len(slopes)].T @ slopes
        return slope

    def variance_near(self, action: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how the variance of a prediction changes with the action.

        Of each entry of f(q + s) it is v(q) + 2 rise' s + s' curvature s, with phi taken as linear
        in s. It comes from the parameters that are not known yet: it is small where examples were.

        Parameters
        ----------
        action : array
            The action q, shape (m,).

        Returns
        -------
        tuple
            rise, shape (m,), and curvature, shape (m, m).
        """
        slopes = self._slopes(action)
        size = len(slopes)
        features = np.empty(size)
        _features(action - self._home, self._factors, features)
        spread = self._covariance[:size, :size] @ slopes
        return spread.T @ features, slopes.T @ spread

    def _slopes(self, action: FloatArray) -> FloatArray:
        """Return dphi/dq at an action, shape (features, m)."""
        slopes = np.empty((len(self._factors), action.size))
        _slopes(action - self._home, self._factors, slopes)
        return slopes

    def expect(self, action: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """Return what the next example is expected to be, before it is learned.

        Parameters
        ----------
        action : array
            The action of the example, shape (m,).

        Returns
        -------
        tuple
            The example's features for `learn`, the outcome expected, shape (n,), and the variance
            of each of its entries that comes from parameters not known yet.
        """
        m = action.size
        features = np.zeros(len(self._parameters))
        _features(action - self._home, self._factors, features[: len(self._factors)])
        if len(self._history):
            features[-2 * m : -m] = action - self._history[0]
        if len(self._history) == 2:
            features[-m:] = action - 2.0 * self._history[0] + self._history[1]
        self._history = np.vstack([action, self._history[:1]])
        return features, features @ self._parameters, _variance(self._covariance, features)

    def learn(self, features: FloatArray, missed: FloatArray) -> None:
        """Learn an example.

        Parameters
        ----------
        features : array
            What `expect` has told.
        missed : array
            Its outcome less what was expected, shape (n,).
        """
        _learn(
            features,
            missed,
            self._parameters,
            self._covariance,
            self._variance,
            self._variance / _MEMORY**2,
        )

    def pause(self) -> None:
        """Forget where the robot came from: the next example is taken as one at rest."""
        self._history = self._history[:0]

    def state(self) -> SavedState:
        """Return everything that `restore` needs."""
        arrays = {
            "home": self._home,
            "parameters": self._parameters.copy(),
            "covariance": self._covariance.copy(),
            "history": self._history,
        }
        return SavedState(arrays, {"variance": self._variance})

    @classmethod
    def restore(cls, state: SavedState) -> "ForwardModel":
        """Return the model whose snapshot this is; it continues bit for bit.

        Raises
        ------
        InvalidConfigError, InvalidArrayError
            If an array or a number does not fit in.
        """
        variance = float(state.settings["variance"])
        if not 0.0 < variance < math.inf:
            raise InvalidConfigError(f"the variance of outcomes must be above 0, got {variance}")
        home = vector("home", state.arrays["home"])
        parameters = matrix("parameters", state.arrays["parameters"])
        covariance = matrix("covariance", state.arrays["covariance"])
        history = matrix_or_empty("history", state.arrays["history"], home.size)
        model = cls(home, parameters[0], 1.0)
        rows = len(model._parameters)
        if len(parameters) != rows or covariance.shape != (rows, rows) or len(history) > 2:
            raise InvalidConfigError(
                f"a forward model of {home.size} actions has {rows} features and at most 2 former "
                f"actions, got parameters {parameters.shape}, a covariance {covariance.shape} and "
                f"{len(history)} actions"
            )
        model._variance = variance
        model._parameters, model._covariance, model._history = parameters, covariance, history
        return model


def _factors(size: int) -> Any:
    """Return which entries every feature is the product of; `size` stands for a factor of 1."""
    rows = [
        chosen + (size,) * (_DEGREE - len(chosen))
        for degree in range(_DEGREE + 1)
        for chosen in combinations_with_replacement(range(size), degree)
    ]
    return np.array(rows)


@numba.njit(cache=True)
def _features(z: FloatArray, factors: Any, features: FloatArray) -> None:
    """Write phi(z)."""
    for row in range(factors.shape[0]):
        product = 1.0
        for column in range(factors.shape[1]):
            if factors[row, column] < z.size:
                product *= z[factors[row, column]]
        features[row] = product


@numba.njit(cache=True)
def _slopes(z: FloatArray, factors: Any, slopes: FloatArray) -> None:
    """Write the derivative of phi(z), shape (features, m)."""
    slopes[:] = 0.0
    for row in range(factors.shape[0]):
        for column in range(factors.shape[1]):
            along = factors[row, column]
            if along == z.size:
                continue
            product = 1.0
            for other in range(factors.shape[1]):
                if other != column and factors[row, other] < z.size:
                    product *= z[factors[row, other]]
            slopes[row, along] += product


@numba.njit(cache=True)
def _variance(covariance: FloatArray, features: FloatArray) -> float:
    """Return a' P a."""
    total = 0.0
    for i in range(features.size):
        row = 0.0
        for j in range(features.size):
            row += covariance[i, j] * features[j]
        total += features[i] * row
    return total


@numba.njit(cache=True)
def _learn(
    features: FloatArray,
    missed: FloatArray,
    parameters: FloatArray,
    covariance: FloatArray,
    variance: float,
    growth: float,
) -> None:
    """Take one step of recursive least squares."""
    size = features.size
    spread = np.empty(size)
    total = variance
    for i in range(size):
        row = 0.0
        for j in range(size):
            row += covariance[i, j] * features[j]
        spread[i] = row
        total += features[i] * row
    for i in range(size):
        gain = spread[i] / total
        for k in range(missed.size):
            parameters[i, k] += gain * missed[k]
        for j in range(i + 1):  # one triangle, mirrored: it stays symmetric to the last bit
            covariance[i, j] -= gain * spread[j]
            covariance[j, i] = covariance[i, j]
        covariance[i, i] += growth
