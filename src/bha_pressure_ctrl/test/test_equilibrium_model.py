"""The inverse equilibrium model: what it fits, refuses, and keeps in a file."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bha_common import bellows
from bha_common.files import ModelFileError, load_versioned, save_versioned
from bha_pressure_ctrl.equilibrium_model import (
    MIN_SAMPLES,
    Array,
    EquilibriumModel,
    EquilibriumModelError,
    fit_equilibrium_model,
)


def robot_samples(count: int, seed: int = 0, noise: float = 0.0) -> tuple[Array, Array, Array]:
    """Return lengths (n, 9) [m], pressures (n, 9) [Pa] and the slope (9, 9) [Pa/m] behind them."""
    rng = np.random.default_rng(seed)
    slope = 5e5 * np.eye(9) + 5e4 * rng.standard_normal((9, 9))
    lengths = 0.2 + 0.03 * rng.uniform(-1.0, 1.0, (count, 9))
    pressures = 6e4 + (lengths - 0.2) @ slope.T
    return lengths + noise * rng.standard_normal(lengths.shape), pressures, slope


def model() -> EquilibriumModel:
    return fit_equilibrium_model(*robot_samples(40)[:2])


class TestFit:
    @pytest.mark.parametrize("count", [MIN_SAMPLES, 60, 500])
    @pytest.mark.parametrize("seed", [0, 1, 2])
    def test_recovers_an_affine_map(self, count: int, seed: int) -> None:
        """Without a penalty exactly, also beyond the samples."""
        lengths, pressures, slope = robot_samples(count, seed)
        fitted = fit_equilibrium_model(lengths, pressures, ridge=0.0)
        np.testing.assert_allclose(fitted.slope, slope, rtol=1e-8, atol=1e-3)
        np.testing.assert_allclose(fitted.pressures(lengths), pressures, atol=1e-6)
        far = np.full(9, 0.3)
        np.testing.assert_allclose(fitted.pressures(far), 6e4 + slope @ (far - 0.2), rtol=1e-9)
        assert fitted.pressure_error < 1e-4
        assert fitted.samples == count

    def test_the_penalty_costs_little(self) -> None:
        """It is there for few and noisy samples: a hundredth of the range is what it may cost."""
        lengths, pressures, _ = robot_samples(60)
        fitted = fit_equilibrium_model(lengths, pressures)
        assert np.abs(fitted.pressures(lengths) - pressures).max() < 0.01 * np.ptp(pressures)

    def test_the_penalty_helps_where_two_bellows_move_alike(self) -> None:
        """Noise of 0.5 mm must not become slopes of opposite signs."""
        lengths, _, _ = robot_samples(60)
        lengths[:, 1] = lengths[:, 0]
        pressures = 5e5 * (lengths - 0.2)
        lengths = lengths + 1e-5 * np.random.default_rng(1).standard_normal(lengths.shape)
        assert np.abs(fit_equilibrium_model(lengths, pressures).slope).max() < 6e5

    def test_the_error_is_that_of_samples_left_out(self) -> None:
        """With as many unknowns as samples the fit is exact, and predicts nothing."""
        rng = np.random.default_rng(3)
        lengths = 0.2 + 0.01 * rng.standard_normal((30, 9))
        pressures = 1e4 * rng.standard_normal((30, 9))
        fitted = fit_equilibrium_model(lengths, pressures)
        inside = np.sqrt(np.mean((fitted.pressures(lengths) - pressures) ** 2))
        assert fitted.pressure_error > 1.1 * inside
        assert fitted.pressure_error > 0.9e4

    def test_the_error_tells_the_noise(self) -> None:
        lengths, pressures, slope = robot_samples(300, noise=1e-3)
        expected = 1e-3 * np.sqrt(np.sum(slope**2) / 9)
        fitted = fit_equilibrium_model(lengths, pressures)
        assert fitted.pressure_error == pytest.approx(expected, rel=0.15)

    def test_many_lengths_at_once(self) -> None:
        fitted, lengths = model(), robot_samples(7)[0]
        one_by_one = np.array([fitted.pressures(row) for row in lengths])
        np.testing.assert_allclose(fitted.pressures(lengths), one_by_one, rtol=1e-12)

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
        first = fit_equilibrium_model(lengths, pressures)
        second = fit_equilibrium_model(lengths + shift, scale * pressures)
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

    @pytest.mark.parametrize("name", ["mean_lengths", "mean_pressures", "slope"])
    def test_a_model_of_wrong_parts(self, name: str) -> None:
        parts: dict[str, Any] = {
            "mean_lengths": np.zeros(9),
            "mean_pressures": np.zeros(9),
            "slope": np.zeros((9, 9)),
        }
        for wrong in (np.zeros((9, 3)), np.full(parts[name].shape, np.nan)):
            with pytest.raises(EquilibriumModelError, match=f"{name} must be finite"):
                EquilibriumModel(**{**parts, name: wrong}, pressure_error=1.0, samples=20)


def test_a_model_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        model().slope[0, 0] = 0.0


def test_a_model_does_not_change_with_what_it_was_made_from() -> None:
    slope = np.eye(9)
    made = EquilibriumModel(np.zeros(9), np.zeros(9), slope, 1.0, 20)
    slope[:] = 7.0
    np.testing.assert_array_equal(made.slope, np.eye(9))


class TestFiles:
    def test_comes_back_to_the_last_bit(self, tmp_path: Path) -> None:
        saved = model()
        saved.save(tmp_path / "model.npz", "bha_1")
        loaded = EquilibriumModel.load(tmp_path / "model.npz", "bha_1")
        for name in ("mean_lengths", "mean_pressures", "slope"):
            assert getattr(loaded, name).tobytes() == getattr(saved, name).tobytes()
        assert (loaded.pressure_error, loaded.samples) == (saved.pressure_error, saved.samples)
        lengths = robot_samples(5)[0]
        np.testing.assert_array_equal(loaded.pressures(lengths), saved.pressures(lengths))

    def test_is_not_for_another_robot(self, tmp_path: Path) -> None:
        model().save(tmp_path / "model.npz", "bha_1")
        with pytest.raises(ModelFileError, match="belongs to robot 'bha_1'"):
            EquilibriumModel.load(tmp_path / "model.npz", "bha_2")

    @pytest.mark.parametrize("part", [0.0, 0.3, 0.9])
    def test_cut(self, tmp_path: Path, part: float) -> None:
        path = tmp_path / "model.npz"
        model().save(path, "bha")
        data = path.read_bytes()
        path.write_bytes(data[: int(part * len(data))])
        with pytest.raises(ModelFileError, match="not a whole model file"):
            EquilibriumModel.load(path, "bha")

    def test_altered(self, tmp_path: Path) -> None:
        path = tmp_path / "model.npz"
        model().save(path, "bha")
        data = bytearray(path.read_bytes())
        for position in range(0, len(data), 101):
            data[position] ^= 4
            path.write_bytes(data)
            with pytest.raises(ModelFileError):
                EquilibriumModel.load(path, "bha")
            data[position] ^= 4

    @pytest.mark.parametrize("change", ["kind", "version"])
    def test_of_another_kind_or_version(self, tmp_path: Path, change: str) -> None:
        path = tmp_path / "model.npz"
        header: dict[str, Any] = {"kind": "equilibrium model", "version": 1}
        header[change] = {"kind": "goal babbling checkpoint", "version": 2}[change]
        save_versioned(path, **header, robot="bha", arrays={}, settings={})
        with pytest.raises(ModelFileError, match=f"{change} is"):
            EquilibriumModel.load(path, "bha")

    def test_whole_files_that_hold_no_whole_model(self, tmp_path: Path) -> None:
        """Any part missing, of a wrong shape, not finite, or one too many."""
        path = tmp_path / "model.npz"
        model().save(path, "bha")
        whole = load_versioned(path, kind="equilibrium model", version=1, robot="bha")

        def refused(arrays: dict[str, Any], values: dict[str, Any]) -> None:
            save_versioned(
                path,
                kind="equilibrium model",
                version=1,
                robot="bha",
                arrays=arrays,
                settings=values,
            )
            with pytest.raises(ModelFileError, match="does not hold a whole model"):
                EquilibriumModel.load(path, "bha")

        for name, array in whole.arrays.items():
            rest = {key: value for key, value in whole.arrays.items() if key != name}
            refused(rest, whole.settings)
            refused({**rest, name: array[:-1]}, whole.settings)
            refused({**rest, name: np.full_like(array, np.nan)}, whole.settings)
            refused({**rest, name: np.full(array.shape, "text")}, whole.settings)
        for name in whole.settings:
            rest = {key: value for key, value in whole.settings.items() if key != name}
            refused(whole.arrays, rest)
        refused({**whole.arrays, "more": np.zeros(1)}, whole.settings)
