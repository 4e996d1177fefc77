"""Model files that are either whole or not there: atomic writes, checked loads."""

from __future__ import annotations

import hashlib
import io
import json
import os
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_HEADER = "header"
_DIGEST_SIZE = 64


class ModelFileError(ValueError):
    """A model file that cannot be used; the message says what is wrong with it."""


@dataclass(frozen=True)
class VersionedFile:
    """What was read from a model file.

    Attributes
    ----------
    arrays : The arrays by name, of the shapes and units they were saved with.
    settings : Plain values that were saved beside them.
    robot : Name of the robot that the model belongs to.
    """

    arrays: dict[str, NDArray[Any]]
    settings: dict[str, Any]
    robot: str


def atomic_write(path: str | os.PathLike[str], data: bytes) -> None:
    """Write a file so that a reader or a crash sees the old content or the new, never a part.

    Parameters
    ----------
    path : Where to write; missing folders are made.
    data : The whole content.
    """
    target = Path(path).expanduser()
    target.parent.mkdir(parents=True, exist_ok=True)
    descriptor, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    try:
        with os.fdopen(descriptor, "wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        # mkstemp makes the file private; a model is to be read by whoever may read the folder.
        umask = os.umask(0)
        os.umask(umask)
        Path(temporary).chmod(0o666 & ~umask)
        Path(temporary).replace(target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise


def save_versioned(
    path: str | os.PathLike[str],
    *,
    kind: str,
    version: int,
    robot: str,
    arrays: Mapping[str, NDArray[Any]],
    settings: Mapping[str, Any],
) -> None:
    """Write arrays and settings with what is needed to refuse them where they do not belong.

    Parameters
    ----------
    path : Where to write.
    kind : What sort of model this is, such as ``"equilibrium model"``.
    version : Version of the format of this kind.
    robot : Name of the robot that the model belongs to.
    arrays : Arrays by name; ``header`` is reserved.
    settings : Values that JSON can hold.

    Raises
    ------
    ValueError
        When an array has the reserved name, or holds objects.
    """
    if _HEADER in arrays:
        raise ValueError(f"an array must not be called {_HEADER!r}: that name is reserved")
    objects = [name for name, array in arrays.items() if np.asarray(array).dtype.hasobject]
    if objects:
        raise ValueError(f"arrays must hold plain numbers; {', '.join(objects)} hold objects")
    header = {"kind": kind, "version": version, "robot": robot, "settings": dict(settings)}
    stream = io.BytesIO()
    contents: dict[str, Any] = {**arrays, _HEADER: np.array(json.dumps(header))}
    np.savez(stream, **contents)  # its own switch against objects is not in every numpy
    atomic_write(path, _signed(stream.getvalue()))


def load_versioned(
    path: str | os.PathLike[str], *, kind: str, version: int, robot: str | None
) -> VersionedFile:
    """Read a model file, or say why it cannot be used.

    Parameters
    ----------
    path : The file.
    kind, version : What the caller can read.
    robot : Name of the robot the model must belong to; None takes any.

    Raises
    ------
    ModelFileError
        When the file is missing, cut, altered, of another kind or version, or of another robot.
    """
    source = Path(path).expanduser()
    try:
        data = source.read_bytes()
    except FileNotFoundError:
        raise ModelFileError(f"{source}: there is no such file") from None
    except IsADirectoryError:
        raise ModelFileError(f"{source}: this is a folder, not a model file") from None
    except PermissionError:
        raise ModelFileError(f"{source}: this file may not be read") from None
    except OSError as error:
        raise ModelFileError(f"{source}: cannot be read ({error.strerror})") from error
    # Checked before anything is made of it: a wrong byte in an archive can raise almost any error.
    if data[-_DIGEST_SIZE:] != _digest(data[:-_DIGEST_SIZE]):
        if zipfile.is_zipfile(io.BytesIO(data)):
            raise ModelFileError(f"{source}: the content was altered (its checksum does not fit)")
        raise ModelFileError(f"{source}: not a whole model file (cut, or something else)")
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        header = json.loads(str(arrays.pop(_HEADER)))
        settings, owner = dict(header["settings"]), str(header["robot"])
        found = {"kind": header["kind"], "version": header["version"]}
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise ModelFileError(
            f"{source}: not a whole model file ({error or type(error).__name__})"
        ) from error
    for name, expected in (("kind", kind), ("version", version)):
        if found[name] != expected:
            raise ModelFileError(
                f"{source}: {name} is {found[name]!r}, but {expected!r} is needed here"
            )
    if robot is not None and owner != robot:
        raise ModelFileError(f"{source}: belongs to robot {owner!r}, but this robot is {robot!r}")
    return VersionedFile(arrays, settings, owner)


def _signed(archive: bytes) -> bytes:
    """Put a checksum of all other bytes at the end of a zip archive, as the archive's comment."""
    body = archive[:-2] + _DIGEST_SIZE.to_bytes(2, "little")  # where the comment's size stands
    return body + _digest(body)


def _digest(data: bytes) -> bytes:
    return hashlib.sha256(data).hexdigest().encode()
