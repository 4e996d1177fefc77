"""An extreme learning machine with direct links that provably rises where it must.

    f(x) = W tanh(A x + a) + D x + d

The hidden layer A, a is drawn at random and stays; W, D, d are fitted by least squares, so every
derivative of f is linear in them. Output i is to rise with its own input i. Its slope is

    df_i/dx_i = D_ii + sum_h c_h s_h(x),    c_h = W_ih A_hi,    s_h = 1 - tanh^2(A x + a)_h

and over a box of inputs every s_h stays within an interval [low_h, high_h] that follows from the
box. So the slope nowhere in the box, between samples or far from them, falls below

    D_ii + sum_h (low_h c_h - (high_h - low_h) max(0, -c_h))

which is concave and piecewise linear in W and D: demanding it of a fit is a quadratic programme.
It is the worst case over the continuous box where Neumann, Rolf and Steil ("Reliable integration of
continuous constraints into extreme learning machines", International Journal of Uncertainty,
Fuzziness and Knowledge-Based Systems 21, 2013) demand it at points, look for violations between
them, and add points. The direct links make that worst case cheap: they carry most of the map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import piqp
from numpy.typing import NDArray

Array = NDArray[np.float64]

_MARGIN = 1e-3  # relative; a solver meets a bound to its tolerance only, so more is demanded of it


class ConstraintError(ValueError):
    """A fit that could not be brought to keep its constraints."""


@dataclass(frozen=True, eq=False)
class Elm:
    """The map f of this module, n inputs and m outputs.

    Attributes
    ----------
    input_weights, biases : Hidden layer A, a; shapes (h, n) and (h,); h may be 0.
    output_weights : W, shape (m, h).
    direct : D, shape (m, n).
    offset : d, shape (m,).
    """

    input_weights: Array
    biases: Array
    output_weights: Array
    direct: Array
    offset: Array

    def __call__(self, x: Array) -> Array:
        """Return f at inputs of shape (n,) or (k, n)."""
        hidden = np.tanh(x @ self.input_weights.T + self.biases)
        values: Array = hidden @ self.output_weights.T + x @ self.direct.T + self.offset
        return values

    def slopes(self, x: Array) -> Array:
        """Return df_i/dx_j at inputs of shape (n,) or (k, n); shape (m, n) or (k, m, n)."""
        rise = 1.0 - np.tanh(x @ self.input_weights.T + self.biases) ** 2
        return self.direct + (rise[..., None, :] * self.output_weights) @ self.input_weights

    def lowest_slopes(self, low: Array, high: Array) -> Array:
        """Bound df_i/dx_i from below over the box from `low` to `high`, both (n,); shape (n,)."""
        least, most = _rise_ranges(self.input_weights, self.biases, low, high)
        products = self.output_weights * self.input_weights.T
        worst = np.minimum(products * least, products * most).sum(axis=1)
        bounds: Array = np.diag(self.direct) + worst
        return bounds


@dataclass(frozen=True, eq=False)
class Penalties:
    """What a fit pays for squared weights, beside the squared errors of k samples."""

    hidden: float
    direct: float  # times k
    trend: float


def draw_hidden_layer(
    neurons: int, inputs: int, spread: float, rng: np.random.Generator, *, single: float = 0.0
) -> tuple[Array, Array]:
    """Draw A and a for inputs of about unit size; `spread` is that of A x where all inputs count.

    A share `single` of the neurons look at one input only, in turn.
    """
    weights = rng.normal(0.0, spread / np.sqrt(inputs), (neurons, inputs))
    few = np.arange(round(single * neurons))
    weights[few] = 0.0
    signs = rng.choice([-1.0, 1.0], len(few))
    weights[few, few % inputs] = signs * rng.uniform(0.5, 1.0, len(few))
    return weights, rng.uniform(-1.5, 1.5, neurons)


def fit_elm(
    x: Array, y: Array, times: Array, hidden: tuple[Array, Array], penalties: Penalties
) -> tuple[Elm, Array]:
    """Fit f(x) + trend * time by least squares; the penalties keep the fit unique.

    Parameters
    ----------
    x : Inputs, shape (k, n).
    y : Outputs, shape (k, m).
    times : When the samples were taken, shape (k,).
    hidden : A and a.
    penalties : What weights cost.

    Returns
    -------
    f, and the trend of every output, shape (m,).
    """
    problem = _Problem.of(x, y, times, hidden, penalties)
    return problem.elm(problem.unconstrained(), hidden)


def fit_rising_elm(
    x: Array,
    y: Array,
    times: Array,
    hidden: tuple[Array, Array],
    penalties: Penalties,
    *,
    low: Array,
    high: Array,
    least_slope: float,
) -> tuple[Elm, Array]:
    """Fit as `fit_elm` does, and fit again each output that cannot be shown to rise in a box.

    Parameters
    ----------
    x, y, times, hidden, penalties : As for `fit_elm`, with as many outputs as inputs.
    low, high : The box, shape (n,).
    least_slope : What every df_i/dx_i must be at least, everywhere in the box; above 0.

    Raises
    ------
    ConstraintError
        When the solver finds no such fit.
    """
    problem = _Problem.of(x, y, times, hidden, penalties)
    weights = problem.unconstrained()
    ranges = _rise_ranges(*hidden, low, high)
    falling = problem.elm(weights, hidden)[0].lowest_slopes(low, high) < least_slope
    for output in np.flatnonzero(falling):
        weights[:, output] = _constrained(problem, hidden[0], int(output), ranges, least_slope)
    fitted, trend = problem.elm(weights, hidden)
    lowest = fitted.lowest_slopes(low, high)
    if not np.all(lowest >= least_slope):
        raise ConstraintError(f"slopes fall to {lowest.min():.3g}, below {least_slope:.3g}")
    return fitted, trend


@dataclass(frozen=True, eq=False)
class _Problem:
    """Normal equations of the centred problem; rows of weights: W', D', trend."""

    gram: Array
    targets: Array
    feature_means: Array
    output_means: Array
    mean_time: float

    @classmethod
    def of(
        cls, x: Array, y: Array, times: Array, hidden: tuple[Array, Array], penalties: Penalties
    ) -> _Problem:
        count, inputs = x.shape
        neurons = len(hidden[1])
        features = np.hstack([np.tanh(x @ hidden[0].T + hidden[1]), x, times[:, None]])
        means = features.mean(axis=0)
        centred, outputs = features - means, y - y.mean(axis=0)
        costs = np.repeat(
            [penalties.hidden, penalties.direct * count, penalties.trend], [neurons, inputs, 1]
        )
        gram = centred.T @ centred + np.diag(costs)
        return cls(gram, centred.T @ outputs, means[:-1], y.mean(axis=0), float(means[-1]))

    def unconstrained(self) -> Array:
        weights: Array = np.linalg.solve(self.gram, self.targets).astype(np.float64)
        return weights

    def elm(self, weights: Array, hidden: tuple[Array, Array]) -> tuple[Elm, Array]:
        neurons, trend = len(hidden[1]), weights[-1].copy()
        offset = self.output_means - self.feature_means @ weights[:-1] - self.mean_time * trend
        direct = weights[neurons:-1].T.copy()
        return Elm(*hidden, weights[:neurons].T.copy(), direct, offset), trend


def _constrained(
    problem: _Problem,
    input_weights: Array,
    output: int,
    ranges: tuple[Array, Array],
    least_slope: float,
) -> Array:
    """Fit the weights of one output; unknowns are they and m_h >= max(0, -c_h)."""
    least, most = ranges
    neurons, size = len(input_weights), len(problem.gram)
    own = input_weights[:, output]
    cost = np.zeros((size + neurons, size + neurons), order="F")
    cost[:size, :size] = problem.gram
    rows = np.zeros((2 * neurons + 1, size + neurons), order="F")
    rows[:neurons, :neurons] = np.diag(own)
    rows[:neurons, size:] = rows[neurons : 2 * neurons, size:] = np.eye(neurons)
    rows[-1, :neurons] = least * own
    rows[-1, neurons + output] = 1.0
    rows[-1, size:] = least - most
    bounds = np.zeros(2 * neurons + 1)
    bounds[-1] = least_slope * (1.0 + _MARGIN)
    solver = piqp.DenseSolver()
    solver.settings.eps_abs = solver.settings.eps_rel = 1e-9
    linear = np.concatenate([-problem.targets[:, output], np.zeros(neurons)])
    solver.setup(cost, linear, G=rows, h_l=bounds)
    status = solver.solve()
    if status != piqp.PIQP_SOLVED:
        raise ConstraintError(f"output {output}: the quadratic programme ended with {status.name}")
    weights: Array = np.array(solver.result.x[:size])
    return weights


def _rise_ranges(weights: Array, biases: Array, low: Array, high: Array) -> tuple[Array, Array]:
    """Return the least and the greatest 1 - tanh^2 of every neuron over a box, shapes (h,)."""
    middle = weights @ (0.5 * (low + high)) + biases
    reach = np.abs(weights) @ (0.5 * (high - low))
    nearest = np.maximum(np.abs(middle) - reach, 0.0)
    return 1.0 - np.tanh(np.abs(middle) + reach) ** 2, 1.0 - np.tanh(nearest) ** 2
