from pathlib import Path

import numpy as np
import pytest

from bha_bringup.in_process import InProcessRobot
from bha_bringup.model_transfer import FILES, adopt_models
from bha_common.files import ModelFileError
from bha_goal_babbling.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from bha_goal_babbling.task import find_task
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Both models of a robot that has just begun to learn."""
    folder = tmp_path_factory.mktemp("models")
    robot = InProcessRobot(find_task("2d"), seed=0)
    robot.identify(20).save(folder / FILES[0], "bha_sim_0")
    robot.babble(20.0)
    assert robot.learner.babbler is not None
    checkpoint = Checkpoint(robot.learner.babbler, "2d", 20.0)
    save_checkpoint(folder / FILES[1], checkpoint, robot="bha_sim_0")
    return folder


def test_models_of_one_robot_become_those_of_another(models: Path, tmp_path: Path) -> None:
    assert adopt_models(models, tmp_path, "lab") == [tmp_path / name for name in FILES]
    with pytest.raises(ModelFileError, match="belongs to robot 'bha_sim_0'"):
        EquilibriumModel.load(models / FILES[0], "lab")
    lengths = np.random.default_rng(0).uniform(0.16, 0.25, 9)
    mine = EquilibriumModel.load(tmp_path / FILES[0], "lab")
    theirs = EquilibriumModel.load(models / FILES[0], "bha_sim_0")
    np.testing.assert_array_equal(mine.pressures(lengths), theirs.pressures(lengths))

    with pytest.raises(ModelFileError, match="belongs to robot 'bha_sim_0'"):
        load_checkpoint(models / FILES[1], robot="lab")
    learned = load_checkpoint(tmp_path / FILES[1], robot="lab", task="2d")
    before = load_checkpoint(models / FILES[1], robot="bha_sim_0")
    assert learned.exploration_time == before.exploration_time
    assert learned.babbler.samples == before.babbler.samples > 0


def test_nothing_is_overwritten(models: Path) -> None:
    with pytest.raises(ValueError, match="is there already"):
        adopt_models(models, models, "lab")


def test_a_folder_without_models(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="holds no models"):
        adopt_models(tmp_path, tmp_path / "lab", "lab")
