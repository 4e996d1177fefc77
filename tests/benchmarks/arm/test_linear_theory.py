"""Theory of linear problems: gradients, their inner product, noise, ignition."""

from typing import Any

import numpy as np
import pytest

from benchmarks.arm import linear_theory


@pytest.fixture
def problem() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return an estimate, a forward matrix, goals without a preferred direction, and noises."""
    rng = np.random.default_rng(0)
    forward = rng.standard_normal((2, 5))
    goals = np.sqrt(2) * np.linalg.qr(rng.standard_normal((2, 2)))[0]
    return rng.standard_normal((5, 2)), forward, goals, linear_theory.isotropic_noises(0.3, 5, 2)


def test_gradients_are_the_numerical_ones(problem: Any) -> None:
    """Of E^X directly; of E^Q with the examples held fixed, as online learning takes them."""
    estimate, forward, goals, noises = problem

    def reaching(g: np.ndarray) -> float:
        return float(np.sum((goals - goals @ (forward @ g).T) ** 2))

    def fitting(g: np.ndarray) -> float:
        actions = np.concatenate([goals @ (estimate + noise).T for noise in noises])
        return float(np.sum((actions - actions @ forward.T @ g.T) ** 2)) / len(noises)

    for error, gradient in (
        (reaching, linear_theory.gradient_of_reaching(estimate, forward, goals)),
        (fitting, linear_theory.gradient_of_examples(estimate, forward, goals, noises)),
    ):
        step = 1e-6 * np.eye(10).reshape(10, 5, 2)
        numerical = [(error(estimate + s) - error(estimate - s)) / 2e-6 for s in step]
        np.testing.assert_allclose(gradient.ravel(), numerical, rtol=1e-5, atol=1e-5)


def test_inner_product_is_that_of_theory(problem: Any) -> None:
    """4 (|D - D^2|^2 goal by goal + n s^2 |(1 - D) F|^2), with goals of unit covariance."""
    estimate, forward, goals, noises = problem
    inner = np.sum(
        linear_theory.gradient_of_examples(estimate, forward, goals, noises)
        * linear_theory.gradient_of_reaching(estimate, forward, goals)
    )
    scale = 2.0  # goals' goals = 2 times the identity
    d = forward @ estimate
    without_noise = scale**2 * np.sum((d - d @ d) ** 2)
    of_noise = scale**2 * 2 * 0.3**2 * np.sum(((np.eye(2) - d) @ forward) ** 2)
    assert inner == pytest.approx(4.0 * (without_noise + of_noise))


def test_noises_have_the_covariance_of_independent_entries() -> None:
    noises = linear_theory.isotropic_noises(0.3, 4, 2).reshape(-1, 8)
    np.testing.assert_allclose(noises.mean(axis=0), 0.0)
    np.testing.assert_allclose(noises.T @ noises / len(noises), 0.09 * np.eye(8), atol=1e-12)


def test_ignition_goes_with_rate_and_noise_squared() -> None:
    """While the reach is far below the noise, D = eta s^2 (n sigma^2 + 1) t."""
    few = np.array([1.0, 2.0])
    weak, strong = (
        linear_theory.ignition_curve(0.01, spread, few, 2, 0.5) for spread in (0.1, 0.2)
    )
    np.testing.assert_allclose(weak, 0.01 * 0.1**2 * (2 * 0.5 + 1) * few, rtol=1e-2)
    np.testing.assert_allclose(strong / weak, 4.0, rtol=1e-2)
