"""The inverse equilibrium model: what it tells, refuses, and keeps in a file."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bha_common import bellows
from bha_common.files import ModelFileError, load_versioned, save_versioned
from bha_pressure_ctrl.bellows_dynamics import TIMES, BellowsDynamics
from bha_pressure_ctrl.bellows_memory import STATES
from bha_pressure_ctrl.constrained_elm import Elm, draw_hidden_layer
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel, EquilibriumModelError

PARTS = ("input_weights", "biases", "output_weights", "direct", "offset")


def model(constrained: bool = True, bend: float = 0.05) -> EquilibriumModel:
    """Return a model with five neurons."""
    rng = np.random.default_rng(0)
    hidden = draw_hidden_layer(5, 9, 0.5, rng)
    direct = 0.15 * np.eye(9) + 0.01 * rng.standard_normal((9, 9))
    elm = Elm(*hidden, bend * rng.standard_normal((9, 5)), direct, np.full(9, 0.5))
    dynamics = BellowsDynamics(
        rng.uniform(0.0, 1e5, (STATES, 9)), 1e4 * np.eye(9), 0.05, 0.2, 0.3, 0.1
    )
    return EquilibriumModel(np.full(9, 0.23), 0.03, elm, 1.3e5, constrained, 4e3, 60, dynamics)


LENGTHS = 0.23 + 0.05 * np.random.default_rng(1).uniform(-1.0, 1.0, (50, 9))


def test_affine_is_what_it_says() -> None:
    slope = 5e5 * np.eye(9) + 1e4
    made = EquilibriumModel.affine(np.full(9, 0.2), np.full(9, 6e4), slope)
    lengths = np.linspace(0.18, 0.22, 9)
    np.testing.assert_allclose(made.pressures(lengths), 6e4 + slope @ (lengths - 0.2))
    np.testing.assert_allclose(made.slopes(lengths), slope)


@pytest.mark.parametrize("constrained", [True, False])
def test_slopes_are_the_numerical_ones(constrained: bool) -> None:
    """Also where the ends bend them."""
    made, step = model(constrained), 1e-6 * np.eye(9)
    for lengths in (LENGTHS[0], np.full(9, 0.12), np.full(9, 0.38)):
        numerical = (made.pressures(lengths + step) - made.pressures(lengths - step)).T / 2e-6
        np.testing.assert_allclose(made.slopes(lengths), numerical, rtol=1e-4, atol=1e-2)
    np.testing.assert_allclose(made.slopes(LENGTHS)[7], made.slopes(LENGTHS[7]))


def test_constraints_change_nothing_in_the_inner_range() -> None:
    near = 0.23 + 0.1 * (LENGTHS - 0.23)
    np.testing.assert_allclose(model().pressures(near), model(False).pressures(near))


def test_a_shift_adds_pressures_and_keeps_the_range() -> None:
    near, shift = 0.23 + 0.1 * (LENGTHS - 0.23), np.linspace(-5e3, 5e3, 9)
    shifted = model().shifted(shift)
    np.testing.assert_allclose(shifted.pressures(near), model().pressures(near) + shift)
    far = model().shifted(np.full(9, -1e6)).pressures(LENGTHS)
    assert (far > 0.0).all()
    assert (far < 2e3).all()
    np.testing.assert_array_equal(shifted.lowest_slopes(), model().lowest_slopes())


class TestRefusals:
    def test_a_model_that_may_fall(self) -> None:
        with pytest.raises(EquilibriumModelError, match="not certain to rise") as caught:
            model(bend=0.5)
        assert "bellows_" in str(caught.value)
        assert not model(constrained=False, bend=0.5).constrained

    def test_only_those_that_may_fall_are_named(self) -> None:
        slope = 5e5 * np.diag([1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
        with pytest.raises(EquilibriumModelError, match="bellows_2_1") as caught:
            EquilibriumModel.affine(np.full(9, 0.2), np.full(9, 6e4), slope)
        assert sum(name in str(caught.value) for name in bellows.NAMES) == 1

    @pytest.mark.parametrize("name", PARTS)
    @pytest.mark.parametrize("wrong", ["shape", "nan"])
    def test_a_network_of_wrong_parts(self, name: str, wrong: str) -> None:
        whole = model()
        part = getattr(whole.elm, name)
        bad = np.zeros((3, 4)) if wrong == "shape" else np.full_like(part, np.nan)
        with pytest.raises(EquilibriumModelError, match="must be finite"):
            replace(whole, elm=replace(whole.elm, **{name: bad}))

    @pytest.mark.parametrize("name", ["length_scale", "max_pressure"])
    @pytest.mark.parametrize("value", [0.0, -1.0, np.nan])
    def test_a_scale_that_is_none(self, name: str, value: float) -> None:
        change: dict[str, Any] = {name: value}
        with pytest.raises(EquilibriumModelError, match=f"{name} must be above 0"):
            replace(model(), **change)


def test_a_model_cannot_be_changed() -> None:
    with pytest.raises(ValueError, match="read-only"):
        model().elm.direct[0, 0] = 0.0


def test_a_model_does_not_change_with_what_it_was_made_from() -> None:
    lengths = np.full(9, 0.2)
    made = EquilibriumModel.affine(lengths, np.full(9, 6e4), 5e5 * np.eye(9))
    lengths[:] = 7.0
    np.testing.assert_array_equal(made.mean_lengths, np.full(9, 0.2))


class TestFiles:
    def test_comes_back_to_the_last_bit(self, tmp_path: Path) -> None:
        saved = model()
        saved.save(tmp_path / "model.npz", "bha_1")
        loaded = EquilibriumModel.load(tmp_path / "model.npz", "bha_1")
        for name in PARTS:
            assert getattr(loaded.elm, name).tobytes() == getattr(saved.elm, name).tobytes()
        assert (loaded.pressure_error, loaded.samples) == (saved.pressure_error, saved.samples)
        assert loaded.constrained
        for name in ("memory", "inertia"):
            one, other = getattr(loaded.dynamics, name), getattr(saved.dynamics, name)
            assert one.tobytes() == other.tobytes()
        for name in TIMES:
            assert getattr(loaded.dynamics, name) == getattr(saved.dynamics, name) > 0.0
        np.testing.assert_array_equal(loaded.pressures(LENGTHS), saved.pressures(LENGTHS))

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
        header: dict[str, Any] = {"kind": "equilibrium model", "version": 3}
        header[change] = {"kind": "goal babbling checkpoint", "version": 1}[change]
        save_versioned(path, **header, robot="bha", arrays={}, settings={})
        with pytest.raises(ModelFileError, match=f"{change} is"):
            EquilibriumModel.load(path, "bha")

    def test_whole_files_that_hold_no_whole_model(self, tmp_path: Path) -> None:
        """Any part missing, of a wrong shape, not finite, or one too many."""
        path = tmp_path / "model.npz"
        model().save(path, "bha")
        whole = load_versioned(path, kind="equilibrium model", version=3, robot="bha")

        def refused(arrays: dict[str, Any], values: dict[str, Any]) -> None:
            save_versioned(
                path,
                kind="equilibrium model",
                version=3,
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
        for name in TIMES:
            for value in (-0.1, float("nan"), 1e3, "text"):
                refused(whole.arrays, {**whole.settings, name: value})
        refused({**whole.arrays, "more": np.zeros(1)}, whole.settings)
        falling = {**whole.arrays, "direct": -whole.arrays["direct"]}
        refused(falling, whole.settings)
