"""Fitting the equilibrium model: what it finds, keeps, and refuses."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_common import bellows
from bha_pressure_ctrl.equilibrium_model import Array, EquilibriumModelError
from bha_pressure_ctrl.model_fitting import MIN_SAMPLES, ModelSettings, fit_equilibrium_model

AFFINE = ModelSettings(neurons=0, constrained=False, trend=False)
EXACT = ModelSettings(neurons=0, constrained=False, trend=False, direct_ridge=0.0)


def robot_samples(count: int, seed: int = 0, noise: float = 0.0) -> tuple[Array, Array, Array]:
    """Return lengths (n, 9) [m], pressures (n, 9) [Pa] and the slope (9, 9) [Pa/m] behind them."""
    rng = np.random.default_rng(seed)
    slope = 5e5 * np.eye(9) + 5e4 * rng.standard_normal((9, 9))
    lengths = 0.2 + 0.03 * rng.uniform(-1.0, 1.0, (count, 9))
    pressures = 6e4 + (lengths - 0.2) @ slope.T
    return lengths + noise * rng.standard_normal(lengths.shape), pressures, slope


def bent_samples(count: int, seed: int = 0, part: float = 1.0) -> tuple[Array, Array]:
    """Return samples of bellows that get stiffer as they get longer, from a part of the range."""
    rng = np.random.default_rng(seed)
    lengths = 0.24 + 0.05 * part * rng.uniform(-1.0, 1.0, (count, 9))
    pulled = (lengths - 0.24) @ (np.eye(9) + 0.1 * rng.standard_normal((9, 9))).T
    return lengths, 6e4 + 6e5 * pulled + 1.5e8 * pulled**3


class TestFit:
    @pytest.mark.parametrize("count", [MIN_SAMPLES, 60, 500])
    @pytest.mark.parametrize("seed", [0, 1, 2])
    def test_recovers_an_affine_map(self, count: int, seed: int) -> None:
        """Without a penalty exactly, also beyond the samples."""
        lengths, pressures, slope = robot_samples(count, seed)
        fitted = fit_equilibrium_model(lengths, pressures, EXACT)
        np.testing.assert_allclose(fitted.slopes(lengths[0]), slope, rtol=1e-8, atol=1e-3)
        np.testing.assert_allclose(fitted.pressures(lengths), pressures, atol=1e-6)
        far = np.full(9, 0.3)
        np.testing.assert_allclose(fitted.pressures(far), 6e4 + slope @ (far - 0.2), rtol=1e-9)
        assert fitted.pressure_error < 1e-4
        assert fitted.samples == count

    def test_the_penalty_costs_little(self) -> None:
        """It is there for few and noisy samples: a hundredth of the range is what it may cost."""
        lengths, pressures, _ = robot_samples(60)
        fitted = fit_equilibrium_model(lengths, pressures, AFFINE)
        assert np.abs(fitted.pressures(lengths) - pressures).max() < 0.01 * np.ptp(pressures)

    def test_the_penalty_helps_where_two_bellows_move_alike(self) -> None:
        """Noise of 0.5 mm must not become slopes of opposite signs."""
        lengths, _, _ = robot_samples(60)
        lengths[:, 1] = lengths[:, 0]
        pressures = 5e5 * (lengths - 0.2)
        lengths = lengths + 1e-5 * np.random.default_rng(1).standard_normal(lengths.shape)
        assert (
            np.abs(fit_equilibrium_model(lengths, pressures, AFFINE).slopes(np.full(9, 0.2))).max()
            < 6e5
        )

    def test_the_error_is_that_of_samples_left_out(self) -> None:
        """With as many unknowns as samples the fit is exact, and predicts nothing."""
        rng = np.random.default_rng(3)
        lengths = 0.2 + 0.01 * rng.standard_normal((30, 9))
        pressures = 1e4 * rng.standard_normal((30, 9))
        fitted = fit_equilibrium_model(lengths, pressures, AFFINE)
        inside = np.sqrt(np.mean((fitted.pressures(lengths) - pressures) ** 2))
        assert fitted.pressure_error > 1.1 * inside
        assert fitted.pressure_error > 0.9e4

    def test_the_error_tells_the_noise(self) -> None:
        lengths, pressures, slope = robot_samples(300, noise=1e-3)
        expected = 1e-3 * np.sqrt(np.sum(slope**2) / 9)
        fitted = fit_equilibrium_model(lengths, pressures, AFFINE)
        assert fitted.pressure_error == pytest.approx(expected, rel=0.15)

    def test_many_lengths_at_once(self) -> None:
        fitted, lengths = fit_equilibrium_model(*bent_samples(40)), robot_samples(7)[0]
        one_by_one = np.array([fitted.pressures(row) for row in lengths])
        np.testing.assert_allclose(fitted.pressures(lengths), one_by_one, rtol=1e-12)

    def test_the_neurons_bend_where_the_robot_does(self) -> None:
        """Three quarters of what an affine map leaves on samples that it has not seen."""
        lengths, pulled, _ = robot_samples(120)
        sideways = (lengths - 0.2) @ np.random.default_rng(1).standard_normal((9, 9)) / 3.0
        pressures = pulled + 2e7 * sideways**2
        fitted = fit_equilibrium_model(lengths, pressures, ModelSettings(single=0.0))
        affine = fit_equilibrium_model(lengths, pressures, AFFINE)
        assert fitted.pressure_error < 0.75 * affine.pressure_error

    def test_few_samples_tell_how_each_bellows_hardens(self) -> None:
        """By neurons that look at it alone; those that look at all cannot tell it apart."""
        rng = np.random.default_rng(2)
        lengths = 0.2 + 0.04 * rng.uniform(-1.0, 1.0, (60, 9))
        x = lengths - 0.2
        slope = 1e6 * np.eye(9) + 5e4 * rng.standard_normal((9, 9))
        pressures = 6e4 + x @ slope.T + 6e6 * x**2 + 2e8 * x**3
        alone, all_at_once = (
            fit_equilibrium_model(lengths, pressures, ModelSettings(single=share))
            for share in (0.9, 0.0)
        )
        assert alone.pressure_error < 0.7 * all_at_once.pressure_error

    def test_a_drift_of_the_robot_is_taken_out(self) -> None:
        """The model is that of the last sample, not of the mean one."""
        lengths, pressures, _ = robot_samples(60)
        aged = pressures - np.linspace(8e3, 0.0, 60)[:, None]
        fitted = fit_equilibrium_model(lengths, aged, ModelSettings(constrained=False))
        errors = fitted.pressures(lengths) - pressures
        assert np.abs(errors.mean(axis=0)).max() < 300.0
        left = fit_equilibrium_model(lengths, aged, AFFINE)
        assert (left.pressures(lengths) - pressures).mean() < -3e3

    def test_does_not_change_the_samples(self) -> None:
        lengths, pressures, _ = robot_samples(40)
        copies = lengths.copy(), pressures.copy()
        fit_equilibrium_model(lengths, pressures)
        np.testing.assert_array_equal(lengths, copies[0])
        np.testing.assert_array_equal(pressures, copies[1])

    @settings(max_examples=20, deadline=None)
    @given(scale=st.floats(0.1, 10.0), shift=st.floats(-0.05, 0.05))
    def test_pressures_in_another_unit(self, scale: float, shift: float) -> None:
        """The fit is linear in the pressures, and shifting all lengths shifts the model."""
        lengths, pressures, _ = robot_samples(40)
        free = ModelSettings(constrained=False)
        first = fit_equilibrium_model(lengths, pressures, free)
        second = fit_equilibrium_model(lengths + shift, scale * pressures, free)
        np.testing.assert_allclose(
            second.pressures(lengths + shift), scale * first.pressures(lengths), rtol=1e-6
        )


class TestRefusals:
    """No model is better than a wrong one."""

    def test_too_few_samples(self) -> None:
        lengths, pressures, _ = robot_samples(MIN_SAMPLES - 1)
        with pytest.raises(EquilibriumModelError, match="19 settled samples; at least 20"):
            fit_equilibrium_model(lengths, pressures)

    def test_none_at_all(self) -> None:
        with pytest.raises(EquilibriumModelError, match="0 settled samples"):
            fit_equilibrium_model(np.empty((0, 9)), np.empty((0, 9)))

    @pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
    @pytest.mark.parametrize("which", [0, 1])
    def test_numbers_that_are_none(self, value: float, which: int) -> None:
        samples = robot_samples(40)[:2]
        samples[which][17, 4] = value
        with pytest.raises(EquilibriumModelError, match="finite"):
            fit_equilibrium_model(*samples)

    @pytest.mark.parametrize("still", [(0,), (3, 8), tuple(range(9))])
    def test_bellows_that_do_not_move(self, still: tuple[int, ...]) -> None:
        """A valve without air, or a potentiometer that is not connected."""
        lengths, pressures, _ = robot_samples(40)
        lengths[:, still] = 0.2 + 2e-4 * np.random.default_rng(0).random((40, len(still)))
        with pytest.raises(EquilibriumModelError, match="hardly changed") as caught:
            fit_equilibrium_model(lengths, pressures)
        for k, name in enumerate(bellows.NAMES):
            assert (name in str(caught.value)) == (k in still)

    @pytest.mark.parametrize(
        ("lengths", "pressures"), [((40, 8), (40, 9)), ((40, 9), (39, 9)), ((40, 9), (40, 10))]
    )
    def test_wrong_shapes(self, lengths: tuple[int, int], pressures: tuple[int, int]) -> None:
        with pytest.raises(EquilibriumModelError, match=r"shape \(n, 9\)"):
            fit_equilibrium_model(np.zeros(lengths), np.zeros(pressures))


class TestConstraints:
    """Every pressure rises with its own length within its range, wherever a length can be meant."""

    @staticmethod
    def anywhere(count: int = 4000, seed: int = 0) -> Array:
        """Return lengths in the whole box, among them its corners."""
        rng, ends = np.random.default_rng(seed), (bellows.MIN_LENGTH, bellows.MAX_LENGTH)
        return np.vstack([rng.uniform(*ends, (count, 9)), rng.choice(ends, (count, 9))])

    @pytest.mark.parametrize("count", [20, 30, 120])
    @pytest.mark.parametrize("part", [1.0, 1.0 / 3.0])
    @pytest.mark.parametrize("noise", [0.0, 5e-3])
    def test_hold_with_few_samples_from_a_part_and_with_noise(
        self, count: int, part: float, noise: float
    ) -> None:
        lengths, pressures = bent_samples(count, part=part)
        lengths = lengths + noise * np.random.default_rng(1).standard_normal(lengths.shape)
        fitted = fit_equilibrium_model(lengths, pressures)
        lowest = fitted.lowest_slopes()
        assert (lowest >= ModelSettings().min_slope * (1.0 - 1e-5)).all()
        points = self.anywhere()
        reached = fitted.pressures(points)
        assert (reached > 0.0).all()
        assert (reached < bellows.MAX_PRESSURE).all()
        for k in range(9):
            longer = points.copy()
            longer[:, k] += 1e-4
            assert (fitted.pressures(longer)[:, k] > reached[:, k]).all()

    def test_without_them_neither_holds(self) -> None:
        """The test above can fail."""
        lengths, pressures = bent_samples(30, part=1.0 / 3.0)
        noisy = lengths + 5e-3 * np.random.default_rng(1).standard_normal(lengths.shape)
        loose = ModelSettings(constrained=False, ridge=1e-3)
        fitted = fit_equilibrium_model(noisy, pressures, loose)
        points = self.anywhere()
        assert np.diagonal(fitted.slopes(points), axis1=1, axis2=2).min() < 0.0
        assert fitted.pressures(points).min() < 0.0

    def test_a_robot_that_is_the_other_way_round_is_no_reason_to_fall(self) -> None:
        """Hoses changed over: pressures fall with their lengths. The model holds its ground."""
        lengths, pressures = bent_samples(60)
        fitted = fit_equilibrium_model(lengths, 1.2e5 - pressures)
        assert (fitted.lowest_slopes() > 0.0).all()
        assert fitted.pressure_error > 1e4  # and the error tells

    def test_they_cost_little_on_a_robot_that_keeps_them(self) -> None:
        samples = bent_samples(120)
        free = fit_equilibrium_model(*samples, ModelSettings(constrained=False))
        assert fit_equilibrium_model(*samples).pressure_error < 1.05 * free.pressure_error
