"""The constrained extreme learning machine: its slopes, its certificate, its fits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_pressure_ctrl.constrained_elm import (
    Array,
    ConstraintError,
    Elm,
    Penalties,
    draw_hidden_layer,
    fit_elm,
    fit_rising_elm,
)

SIZE = 3
LOW, HIGH = np.full(SIZE, -3.0), np.full(SIZE, 3.0)
LOOSE = Penalties(hidden=1e-4, direct=1e-6, trend=1e-6)


def random_elm(seed: int = 0, neurons: int = 12) -> Elm:
    rng = np.random.default_rng(seed)
    hidden = draw_hidden_layer(neurons, SIZE, 1.5, rng)
    return Elm(
        *hidden,
        0.3 * rng.standard_normal((SIZE, neurons)),
        np.eye(SIZE) + 0.2 * rng.standard_normal((SIZE, SIZE)),
        rng.standard_normal(SIZE),
    )


def wavy_samples(count: int = 80, seed: int = 0) -> tuple[Array, Array, Array]:
    """Return inputs, outputs that fall in the middle of their range, and times."""
    x = np.random.default_rng(seed).uniform(-2.0, 2.0, (count, SIZE))
    return x, 0.5 * x - 1.2 * np.sin(2.0 * x), np.zeros(count)


def own(slopes: Array) -> Array:
    return np.diagonal(slopes, axis1=-2, axis2=-1)


def test_slopes_are_the_numerical_ones() -> None:
    elm, x = random_elm(), np.array([0.3, -1.2, 0.7])
    steps = 1e-5 * np.eye(SIZE)
    numerical = (elm(x + steps) - elm(x - steps)).T / 2e-5
    np.testing.assert_allclose(elm.slopes(x), numerical, rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(elm.slopes(np.stack([x, -x]))[0], elm.slopes(x))


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 10_000), middle=st.floats(-3.0, 3.0), half=st.floats(0.0, 3.0))
def test_no_slope_in_the_box_is_below_the_certificate(
    seed: int, middle: float, half: float
) -> None:
    elm, rng = random_elm(seed), np.random.default_rng(seed)
    low, high = np.full(SIZE, middle - half), np.full(SIZE, middle + half)
    x = rng.uniform(low, high, (200, SIZE))
    bounds = elm.lowest_slopes(low, high)
    assert (own(elm.slopes(x)) >= bounds - 1e-9).all()


def test_the_certificate_of_a_point_is_the_slope_there() -> None:
    elm, x = random_elm(), np.array([0.3, -1.2, 0.7])
    np.testing.assert_allclose(elm.lowest_slopes(x, x), own(elm.slopes(x)))


def test_the_certificate_of_one_neuron_is_exact() -> None:
    """f = x - 2 tanh(x) falls steepest at 0, by 1, and rises least from 1 to 2 at 1."""
    elm = Elm(np.eye(1), np.zeros(1), -2.0 * np.eye(1), np.eye(1), np.zeros(1))
    one, two = np.ones(1), np.full(1, 2.0)
    np.testing.assert_allclose(elm.lowest_slopes(-one, two), -1.0)
    np.testing.assert_allclose(elm.lowest_slopes(one, two), 1.0 - 2.0 / np.cosh(1.0) ** 2)


def test_a_fit_finds_the_map_behind_the_samples() -> None:
    rng, wanted = np.random.default_rng(3), random_elm()
    x, times = rng.uniform(-2.0, 2.0, (200, SIZE)), rng.uniform(-1.0, 0.0, 200)
    trend = np.array([0.5, -1.0, 0.0])
    y = wanted(x) + times[:, None] * trend
    hidden = wanted.input_weights, wanted.biases
    fitted, found = fit_elm(x, y, times, hidden, Penalties(1e-9, 0.0, 0.0))
    np.testing.assert_allclose(found, trend, atol=1e-6)
    np.testing.assert_allclose(fitted(x), wanted(x), atol=1e-5)


class TestRising:
    """Samples that fall, and a fit that must not."""

    hidden = draw_hidden_layer(30, SIZE, 3.0, np.random.default_rng(1))

    def test_without_the_constraint_it_falls(self) -> None:
        """The tests below can fail."""
        x, y, times = wavy_samples()
        fitted, _ = fit_elm(x, y, times, self.hidden, LOOSE)
        assert own(fitted.slopes(x)).min() < -0.5

    @pytest.mark.parametrize("least", [0.01, 0.3])
    @pytest.mark.parametrize("seed", range(4))
    def test_it_rises_everywhere_in_the_box(self, seed: int, least: float) -> None:
        x, y, times = wavy_samples(seed=seed)
        fitted, _ = fit_rising_elm(
            x, y, times, self.hidden, LOOSE, low=LOW, high=HIGH, least_slope=least
        )
        assert (fitted.lowest_slopes(LOW, HIGH) >= least * (1 - 1e-6)).all()
        rng = np.random.default_rng(seed)
        anywhere = np.vstack([rng.uniform(LOW, HIGH, (5000, SIZE)), rng.choice([-3, 3], (8, SIZE))])
        assert own(fitted.slopes(anywhere)).min() >= least * (1 - 1e-6)

    def test_it_is_the_best_of_those_that_rise(self) -> None:
        """Any way from it to a looser one that stays certified costs."""
        x, y, times = wavy_samples()
        costs = Penalties(hidden=1e-2, direct=1e-3, trend=1e6)

        def cost(elm: Elm) -> float:
            errors = np.sum((elm(x) - y) ** 2)
            weights = 1e-2 * np.sum(elm.output_weights**2) + 1e-3 * len(x) * np.sum(elm.direct**2)
            return float(errors + weights)

        fitted, _ = fit_rising_elm(
            x, y, times, self.hidden, costs, low=LOW, high=HIGH, least_slope=0.1
        )
        rng, kept = np.random.default_rng(0), 0
        for _ in range(2000):
            other = Elm(
                *self.hidden,
                fitted.output_weights + 1e-3 * rng.standard_normal((SIZE, 30)),
                fitted.direct + 2e-2 * rng.random() * np.eye(SIZE),
                fitted.offset,
            )
            if (other.lowest_slopes(LOW, HIGH) >= 0.1).all():
                kept += 1
                assert cost(other) > cost(fitted) - 1e-9
        assert kept > 20

    def test_what_rises_by_itself_is_left_alone(self) -> None:
        x, _, times = wavy_samples()
        y = x + 0.1 * np.tanh(x)
        costs = Penalties(hidden=0.1, direct=1e-3, trend=1e-2)
        free, _ = fit_elm(x, y, times, self.hidden, costs)
        fitted, _ = fit_rising_elm(
            x, y, times, self.hidden, costs, low=LOW, high=HIGH, least_slope=0.1
        )
        np.testing.assert_array_equal(fitted.output_weights, free.output_weights)

    def test_a_constraint_that_no_solver_meets(self) -> None:
        x, y, times = wavy_samples()
        with pytest.raises(ConstraintError):
            fit_rising_elm(x, y, times, self.hidden, LOOSE, low=LOW, high=HIGH, least_slope=np.nan)
