"""What a package imports, its package.xml declares: a native build installs nothing else."""

import ast
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src"
PACKAGES = sorted(path.parent for path in SOURCE.glob("*/setup.py"))

# The rosdep key of an import, where it is not the import's own name. numba and piqp have none for
# Ubuntu 24.04; CONTRIBUTING.md says how they get there.
KEYS = {
    name: f"python3-{name}"
    for name in ("hypothesis", "matplotlib", "numpy", "pytest", "rich", "scipy", "typer")
} | {
    "mujoco": "python3-mujoco-pip",
    "pymodbus": "python3-pymodbus-pip",
    "yaml": "python3-yaml",
}
WITHOUT_KEY = {"numba", "piqp"}


def imported(folder: Path) -> set[str]:
    """Return the top-level names that a folder's modules import."""
    names: set[str] = set()
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                names |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                names.add(node.module.split(".")[0])
    return names - sys.stdlib_module_names - WITHOUT_KEY


def declared(package: Path, *tags: str) -> set[str]:
    manifest = ElementTree.parse(package / "package.xml").getroot()
    return {str(entry.text).strip() for tag in tags for entry in manifest.iter(tag)}


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_imports_are_declared(package: Path) -> None:
    run = declared(package, "depend", "exec_depend")
    needs = {KEYS.get(name, name) for name in imported(package / package.name) - {package.name}}
    launch = {KEYS.get(name, name) for name in imported(package / "launch") - {package.name}}
    assert needs | launch <= run, f"package.xml lacks {sorted((needs | launch) - run)}"

    test = run | declared(package, "test_depend")
    wanted = {KEYS.get(name, name) for name in imported(package / "test") - {package.name}}
    assert wanted <= test, f"package.xml lacks <test_depend> {sorted(wanted - test)}"
