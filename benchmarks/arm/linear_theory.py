"""What theory says of learning on linear problems, x = F q.

The estimate is g(x*) = G x*. With exploratory noise an example is q = (G + A) x*, x = F q.

    E^Q = sum |q - G x|^2,   dE^Q/dG = -2 sum (q - G x) x'      (fitting examples)
    E^X = sum |x* - F G x*|^2,   dE^X/dG = -2 F' sum (x* - F G x*) x*'   (reaching goals)

(equations 2 and following of the article; examples count as given, as they do online). For goals
and noise without a preferred direction the two gradients never oppose each other (Rolf and Steil,
"Explorative learning of inverse models: a theoretical perspective", 2014): with D = F G their inner
product is 4 (|D - D^2|^2 + n s^2 |(1 - D) F|^2).
"""

import numpy as np
from scipy.integrate import solve_ivp

from bha_goal_babbling.arrays import FloatArray


def gradient_of_examples(
    estimate: FloatArray, forward: FloatArray, goals: FloatArray, noises: FloatArray
) -> FloatArray:
    """Return dE^Q/dG over all pairs of a goal and a noise, shape (m, n).

    Parameters
    ----------
    estimate : array
        G, shape (m, n).
    forward : array
        F, shape (n, m).
    goals : array
        Shape (g, n).
    noises : array
        Matrices A, shape (a, m, n).
    """
    gradient = np.zeros_like(estimate)
    for noise in noises:
        actions = goals @ (estimate + noise).T
        outcomes = actions @ forward.T
        gradient -= 2.0 * (actions - outcomes @ estimate.T).T @ outcomes
    return gradient / len(noises)


def gradient_of_reaching(
    estimate: FloatArray, forward: FloatArray, goals: FloatArray
) -> FloatArray:
    """Return dE^X/dG over all goals, shape (m, n); see `gradient_of_examples`."""
    return -2.0 * forward.T @ (goals - goals @ (forward @ estimate).T).T @ goals


def isotropic_noises(spread: float, m: int, n: int) -> FloatArray:
    """Return matrices A with mean 0 and the covariance of independent entries N(0, s^2).

    E^Q is quadratic in A, so its mean over these few is exactly that over the distribution.

    Returns
    -------
    array
        Shape (2 m n, m, n).
    """
    entries = spread * np.sqrt(m * n) * np.eye(m * n).reshape(-1, m, n)
    return np.concatenate([entries, -entries])


def inner_products(rng: np.random.Generator, problems: int) -> tuple[list[float], list[float]]:
    """Return the inner products of the two gradients, and their cosines, on random problems.

    Where a gradient vanishes there is no cosine.
    """
    products: list[float] = []
    cosines: list[float] = []
    for _ in range(problems):
        n = int(rng.integers(1, 4))
        m = int(rng.integers(n, 21))
        forward = rng.standard_normal((n, m)) / np.sqrt(m)
        # From no estimate to a wild one, from no noise to much; and near what is optimal.
        estimate = rng.choice([0.0, 0.1, 1.0, 3.0]) * rng.standard_normal((m, n))
        estimate += rng.choice([0.0, 1.0]) * np.linalg.pinv(forward)
        goals = np.sqrt(n) * np.linalg.qr(rng.standard_normal((n, n)))[0]
        noises = isotropic_noises(rng.choice([0.0, 0.1, 1.0]), m, n)
        by_examples = gradient_of_examples(estimate, forward, goals, noises)
        by_reaching = gradient_of_reaching(estimate, forward, goals)
        products.append(float(np.sum(by_examples * by_reaching)))
        length = np.linalg.norm(by_examples) * np.linalg.norm(by_reaching)
        if length > 1e-9:
            cosines.append(products[-1] / float(length))
    return products, cosines


def ignition_curve(
    rate: float, spread: float, samples: FloatArray, outcomes: int, variance: float
) -> FloatArray:
    """Return the share D of the reach after some samples by theory, same shape.

    Without weights, with targets of variance sigma^2 a coordinate and noise A x* + c, the mean
    step of D = F G is

        dD/dt = eta (1 - D) (sigma^2 D^2 + s^2 (n sigma^2 + 1)).

    First the noise alone drives it (ignition, D ~ eta s^2 t), then D^2 (growth that feeds itself),
    then 1 - D ends it (saturation).

    Parameters
    ----------
    rate : Learning rate eta.
    spread : Noise s.
    samples : Numbers of samples, growing, shape (N,).
    outcomes : Number n of coordinates of an outcome.
    variance : sigma^2.
    """

    def step(_: float, reach: FloatArray) -> FloatArray:
        driven: FloatArray = variance * reach**2 + spread**2 * (outcomes * variance + 1.0)
        return rate * (1.0 - reach) * driven

    solution = solve_ivp(step, (0.0, float(samples[-1])), [0.0], t_eval=samples, rtol=1e-8)
    reach: FloatArray = solution.y[0]
    return reach
