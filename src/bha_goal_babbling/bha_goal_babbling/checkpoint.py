"""Checkpoints: a whole learner in one file that is either complete and unaltered or refused."""

import os

from bha_common.files import ModelFileError, load_versioned, save_versioned
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.saved_state import SavedState

KIND = "goal babbling checkpoint"
VERSION = 1


def save_checkpoint(path: str | os.PathLike[str], babbler: GoalBabbler, *, robot: str) -> None:
    """Write a learner to a file, so that a crash leaves the old file or the new one.

    Parameters
    ----------
    path : str or path
        Where to write.
    babbler : GoalBabbler
        The learner; it may be between `ask` and `tell`.
    robot : str
        Name of the robot that it has learned on.
    """
    state = babbler.state()
    save_versioned(
        path,
        kind=KIND,
        version=VERSION,
        robot=robot,
        arrays=state.arrays,
        settings=state.settings,
    )


def load_checkpoint(path: str | os.PathLike[str], *, robot: str | None) -> GoalBabbler:
    """Return the learner from a file; it continues bit for bit as the one that was saved.

    Parameters
    ----------
    path : str or path
        The file.
    robot : str or None
        Name of the robot the learner must belong to; None takes any.

    Raises
    ------
    ModelFileError
        If the file is missing, cut, altered, of another kind or version, of another robot, or
        does not hold a learner.
    """
    file = load_versioned(path, kind=KIND, version=VERSION, robot=robot)
    try:
        return GoalBabbler.restore(SavedState(file.arrays, file.settings))
    except (GoalBabblingError, KeyError, TypeError, ValueError, IndexError) as error:
        raise ModelFileError(
            f"{path}: the file does not hold a whole learner: {error!r}"
        ) from error
