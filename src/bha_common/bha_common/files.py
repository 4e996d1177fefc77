"""Model files that are either whole or not there: atomic writes, checked loads."""

from __future__ import annotations

import hashlib
import io
import json
import lzma
import os
import struct
import tempfile
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_HEADER = "header"
# All that zipfile and numpy were seen to raise, or can raise, where a byte of a file is wrong.
_BROKEN = (
    *(OSError, EOFError, ValueError, TypeError, LookupError, RuntimeError, MemoryError),
    *(SyntaxError, OverflowError, struct.error, zipfile.BadZipFile, zlib.error, lzma.LZMAError),
)


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
        When an array has the reserved name.
    """
    if _HEADER in arrays:
        raise ValueError(f"an array must not be called {_HEADER!r}: that name is reserved")
    contents = {name: np.asarray(array, order="C") for name, array in arrays.items()}
    header = {
        "kind": kind,
        "version": version,
        "robot": robot,
        "settings": dict(settings),
    }
    text = json.dumps(header, sort_keys=True)
    checked = json.dumps({"header": text, "sha256": _digest(text, contents)})
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **{_HEADER: np.array(checked)}, **contents)
    atomic_write(path, stream.getvalue())


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
        with np.load(source, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        checked = json.loads(str(arrays.pop(_HEADER)))
        text, digest = checked["header"], checked["sha256"]
        header = json.loads(text)
        settings, owner = dict(header["settings"]), str(header["robot"])
        kept = {"kind": header["kind"], "version": header["version"]}
    except FileNotFoundError:
        raise ModelFileError(f"{source}: there is no such file") from None
    except IsADirectoryError:
        raise ModelFileError(f"{source}: this is a folder, not a model file") from None
    except PermissionError:
        raise ModelFileError(f"{source}: this file may not be read") from None
    except _BROKEN as error:
        raise ModelFileError(
            f"{source}: not a whole model file ({error or type(error).__name__})"
        ) from error
    if digest != _digest(text, arrays):
        raise ModelFileError(f"{source}: the content was altered (its checksum does not fit)")
    for name, expected in (("kind", kind), ("version", version)):
        if kept[name] != expected:
            raise ModelFileError(
                f"{source}: {name} is {kept[name]!r}, but {expected!r} is needed here"
            )
    if robot is not None and owner != robot:
        raise ModelFileError(f"{source}: belongs to robot {owner!r}, but this robot is {robot!r}")
    return VersionedFile(arrays, settings, owner)


def _digest(text: str, arrays: Mapping[str, NDArray[Any]]) -> str:
    """Checksum over the header and, in order of names, type, shape and bytes of each array."""
    digest = hashlib.sha256(text.encode())
    for name in sorted(arrays):
        array = arrays[name]
        digest.update(f"|{name}|{array.dtype.str}|{array.shape}|".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
