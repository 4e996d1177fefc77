"""What a run was made with: the code, and the libraries that decide about numbers."""

import hashlib
import importlib.metadata
import platform
from functools import cache
from pathlib import Path

import benchmarks
import bha_goal_babbling

_LIBRARIES = ("numpy", "scipy", "numba", "matplotlib", "joblib", "dask", "distributed")
_NUMERIC = ("python", "numpy", "scipy", "numba")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries, by name."""
    found = {"python": platform.python_version()}
    return found | {name: importlib.metadata.version(name) for name in _LIBRARIES}


@cache
def fingerprint() -> str:
    """Return what tells these tables and this learner from any others, as 16 hexadecimal digits.

    It changes with every Python file of the two packages, and with the libraries behind numbers:
    a run with another fingerprint may have brought other figures.
    """
    digest = hashlib.sha256()
    for package in (benchmarks, bha_goal_babbling):
        folder = Path(package.__path__[0])
        for path in sorted(folder.rglob("*.py")):
            digest.update(f"{package.__name__}/{path.relative_to(folder)}\0".encode())
            digest.update(path.read_bytes() + b"\0")
    for name in _NUMERIC:
        digest.update(f"{name}=={versions()[name]}\0".encode())
    return digest.hexdigest()[:16]
