"""Features for the regression of a function of many inputs: the input itself and random waves.

    phi(z) = [1, z / l, sqrt(2 / F) cos(w_i . z + b_i)],   w_i ~ N(0, 1 / l^2),  b_i ~ U(0, 2 pi)

The waves approximate a Gaussian kernel of length l (Rahimi and Recht, "Random features for
large-scale kernel machines", 2007); the input itself makes linear functions exact.
"""

import numpy as np

from bha_goal_babbling.arrays import FloatArray


class RandomFeatures:
    """Features of inputs around an origin, and their derivatives.

    Parameters
    ----------
    origin : array
        Input that is z = 0, shape (m,).
    length : float
        Length l over which the function changes, in the unit of inputs.
    waves : int
        Number F of waves.
    rng : numpy.random.Generator
        Source of frequencies and phases.
    """

    def __init__(
        self, origin: FloatArray, length: float, waves: int, rng: np.random.Generator
    ) -> None:
        self._origin = origin
        self._length = length
        self._frequencies = rng.standard_normal((origin.size, waves)) / length
        self._phases = rng.uniform(0.0, 2.0 * np.pi, waves)
        self._amplitude = np.sqrt(2.0 / waves)
        self.count = 1 + origin.size + waves

    def __call__(self, inputs: FloatArray) -> FloatArray:
        """Return the features of inputs, shape (N, m), as shape (N, 1 + m + F)."""
        z = inputs - self._origin
        waves = self._amplitude * np.cos(z @ self._frequencies + self._phases)
        return np.concatenate([np.ones((len(z), 1)), z / self._length, waves], axis=1)

    def slopes(self, inputs: FloatArray, parameters: FloatArray) -> FloatArray:
        """Return the derivative of y = phi(z) parameters by the input.

        Parameters
        ----------
        inputs : array
            Shape (N, m).
        parameters : array
            Shape (1 + m + F, n).

        Returns
        -------
        array
            Shape (N, n, m).
        """
        m = inputs.shape[1]
        waves = -self._amplitude * np.sin(
            (inputs - self._origin) @ self._frequencies + self._phases
        )
        curved = waves[:, np.newaxis] * parameters[1 + m :].T @ self._frequencies.T
        slopes: FloatArray = parameters[1 : 1 + m].T / self._length + curved
        return slopes
