"""Finds the data files of a package, in the sources as well as in an installed workspace."""

from __future__ import annotations

from pathlib import Path


def share_file(module_file: str, *parts: str) -> Path:
    """Find a data file of the package that a module belongs to.

    Parameters
    ----------
    module_file : The module's ``__file__``.
    parts : Path of the file in the package's share folder, such as ``"config", "robot.yaml"``.

    Raises
    ------
    FileNotFoundError
        When it is neither beside the package nor in a share folder above it.
    """
    here = Path(module_file).resolve()
    package = here.parent.name
    for candidate in (
        here.parents[1].joinpath(*parts),
        *(parent.joinpath("share", package, *parts) for parent in here.parents),
    ):
        if candidate.is_file():
            return candidate
    raise FileNotFoundError(f"{Path(*parts)} of {package} was not found beside or above {here}")
