"""Gives models of one robot to another, which goes on learning from there."""

from __future__ import annotations

from pathlib import Path

from bha_bringup.graph import MODEL_FILES
from bha_goal_babbling.checkpoint import load_checkpoint, save_checkpoint
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel

FILES = tuple(MODEL_FILES.values())


def adopt_models(source: Path, target: Path, robot: str) -> list[Path]:
    """Copy the models in a folder, and write another robot's name into the copies.

    Parameters
    ----------
    source, target : Folders of models, as `bha up --models` keeps them.
    robot : Name of the robot that the copies are for.

    Returns
    -------
    The files that were written.

    Raises
    ------
    ModelFileError
        When a model cannot be used.
    ValueError
        When there is none, or one is there already.
    """
    found = [name for name in FILES if (source / name).is_file()]
    if not found:
        raise ValueError(f"{source} holds no models: {' or '.join(FILES)}")
    for name in found:
        if (target / name).exists():
            raise ValueError(f"{target / name} is there already: choose an empty folder")
    for name in found:
        if name == MODEL_FILES["pressure_ctrl"]:
            EquilibriumModel.load(source / name, None).save(target / name, robot)
        else:
            save_checkpoint(target / name, load_checkpoint(source / name, robot=None), robot=robot)
    return [target / name for name in found]
