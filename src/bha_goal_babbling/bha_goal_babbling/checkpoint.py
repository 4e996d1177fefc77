"""Checkpoints: a whole learner in one file that is either complete and unaltered or refused."""

import os
from dataclasses import dataclass

from bha_common.files import ModelFileError, load_versioned, save_versioned
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.saved_state import SavedState

KIND = "goal babbling checkpoint"
VERSION = 3


@dataclass(frozen=True)
class Checkpoint:
    """What stands in a checkpoint.

    Attributes
    ----------
    babbler : GoalBabbler
        The learner; it may be between `ask` and `tell`.
    task : str
        Name of the task that it learns.
    exploration_time : float
        Robot time that it has explored [s].
    """

    babbler: GoalBabbler
    task: str = ""
    exploration_time: float = 0.0


def save_checkpoint(path: str | os.PathLike[str], checkpoint: Checkpoint, *, robot: str) -> None:
    """Write a learner to a file, so that a crash leaves the old file or the new one.

    Parameters
    ----------
    path : str or path
        Where to write.
    checkpoint : Checkpoint
        What to write.
    robot : str
        Name of the robot that it has learned on.
    """
    state = checkpoint.babbler.state()
    settings = {
        "babbler": state.settings,
        "task": checkpoint.task,
        "exploration_time": checkpoint.exploration_time,
    }
    save_versioned(
        path, kind=KIND, version=VERSION, robot=robot, arrays=state.arrays, settings=settings
    )


def load_checkpoint(
    path: str | os.PathLike[str], *, robot: str | None, task: str | None = None
) -> Checkpoint:
    """Read a learner from a file; it continues bit for bit as the one that was saved.

    Parameters
    ----------
    path : str or path
        The file.
    robot : str or None
        Name of the robot the learner must belong to; None takes any.
    task : str or None
        Name of the task that it must have learned; None takes any.

    Raises
    ------
    ModelFileError
        If the file is missing, cut, altered, of another kind or version, of another robot or
        task, or does not hold a learner.
    """
    file = load_versioned(path, kind=KIND, version=VERSION, robot=robot)
    try:
        checkpoint = Checkpoint(
            GoalBabbler.restore(SavedState(file.arrays, file.settings["babbler"])),
            str(file.settings["task"]),
            float(file.settings["exploration_time"]),
        )
    except (GoalBabblingError, KeyError, TypeError, ValueError, IndexError) as error:
        raise ModelFileError(
            f"{path}: the file does not hold a whole learner: {error!r}"
        ) from error
    if task is not None and checkpoint.task != task:
        raise ModelFileError(
            f"{path}: learned task {checkpoint.task!r}; this learner's is {task!r}"
        )
    return checkpoint
