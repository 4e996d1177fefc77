from pathlib import Path

import numpy as np
import pytest

from bha_bringup.model_transfer import FILES, adopt_models
from bha_common.files import ModelFileError
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel, fit_equilibrium_model

SAMPLES = np.random.default_rng(0)


@pytest.fixture
def models(tmp_path: Path) -> Path:
    lengths = SAMPLES.uniform(0.15, 0.3, (40, 9))
    fit_equilibrium_model(lengths, 5e5 * lengths).save(tmp_path / FILES[0], "bha_sim_0")
    return tmp_path


def test_a_model_of_one_robot_becomes_that_of_another(models: Path, tmp_path: Path) -> None:
    target = tmp_path / "lab"
    assert adopt_models(models, target, "lab") == [target / FILES[0]]
    with pytest.raises(ModelFileError, match="belongs to robot 'bha_sim_0'"):
        EquilibriumModel.load(models / FILES[0], "lab")
    mine, theirs = (EquilibriumModel.load(folder / FILES[0], None) for folder in (target, models))
    assert EquilibriumModel.load(target / FILES[0], "lab").samples == mine.samples
    np.testing.assert_array_equal(mine.slope, theirs.slope)


def test_nothing_is_overwritten(models: Path) -> None:
    with pytest.raises(ValueError, match="is there already"):
        adopt_models(models, models, "lab")


def test_a_folder_without_models(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="holds no models"):
        adopt_models(tmp_path, tmp_path / "lab", "lab")
