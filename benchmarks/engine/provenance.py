"""What a run was made with: the code behind it, and the libraries that decide about numbers."""

import hashlib
import importlib.metadata
import importlib.util
import platform
import sys
from functools import cache
from pathlib import Path

import grimp

_PACKAGES = (
    "benchmarks",
    "bha_bringup",
    "bha_cartesian_feedback",
    "bha_common",
    "bha_driver",
    "bha_goal_babbling",
    "bha_pressure_ctrl",
    "bha_sim",
)
_LIBRARIES = ("numpy", "scipy", "numba", "mujoco", "matplotlib", "joblib", "dask", "distributed")
_NUMERIC = ("python", "numpy", "scipy", "numba", "mujoco")


def versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries, by name."""
    found = {"python": platform.python_version()}
    return found | {name: importlib.metadata.version(name) for name in _LIBRARIES}


@cache
def fingerprint(module: str) -> str:
    """Return what tells the code behind a module from any other, as 16 hexadecimal digits.

    It changes with the module, with every module of the workspace that it imports directly or
    indirectly, with the settings (YAML) of their packages, and with the libraries behind numbers:
    a run with another fingerprint may have brought other figures.

    Parameters
    ----------
    module : str
        Name of the module, such as "benchmarks.arm.linear".
    """
    graph = _imports()
    behind = {module} | (graph.find_upstream_modules(module) if module in graph.modules else set())
    digest = hashlib.sha256()
    for name in sorted(behind):
        digest.update(f"{name}\0".encode() + _source(name).read_bytes() + b"\0")
    for package in sorted(set(_PACKAGES) & {name.partition(".")[0] for name in behind}):
        for path in sorted((_source(package).parents[1] / "config").glob("*.yaml")):
            digest.update(f"{package}/{path.name}\0".encode() + path.read_bytes() + b"\0")
    for name in _NUMERIC:
        digest.update(f"{name}=={versions()[name]}\0".encode())
    return digest.hexdigest()[:16]


@cache
def _imports() -> grimp.ImportGraph:
    return grimp.build_graph(*_PACKAGES, cache_dir=None)


def _source(module: str) -> Path:
    if module in sys.modules:
        origin = sys.modules[module].__file__
    else:
        spec = importlib.util.find_spec(module)
        origin = None if spec is None else spec.origin
    if origin is None:
        raise ModuleNotFoundError(f"{module} has no source file")
    return Path(origin).resolve()
