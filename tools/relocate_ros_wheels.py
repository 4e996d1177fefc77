"""Make the CMake files of the ROS wheels fit the environment they are installed in.

The wheels carry the paths of the machine that built them, for Python's headers and for
numpy's. CMake refuses a target whose include folder does not exist, so both are rewritten to
this interpreter's folders. Run with the Python of the environment that holds the wheels.
"""

import re
import sys
import sysconfig
from pathlib import Path

BUILD_PREFIX = r"/opt/python/cp3\d+-cp3\d+"
HEADERS = re.compile(BUILD_PREFIX + r"/include/python3\.\d+")
SITE_PACKAGES = re.compile(BUILD_PREFIX + r"/lib/python3\.\d+/site-packages")


def relocated(text: str, headers: str, site_packages: str) -> str:
    """Return the text with the build machine's folders replaced by this environment's."""
    text = HEADERS.sub(lambda _: headers, text)
    return SITE_PACKAGES.sub(lambda _: site_packages, text)


def replace(path: Path, text: str) -> None:
    """Put a new file in the place of an old one.

    The old one may be a hard link into the installer's cache, which must stay as it is.
    """
    temporary = path.with_name(f".{path.name}.relocated")
    temporary.write_text(text, encoding="utf-8")
    temporary.chmod(path.stat().st_mode & 0o777)
    temporary.replace(path)


def relocate(prefix: Path, headers: str, site_packages: str) -> int:
    """Rewrite every CMake file under ``prefix``/share; return how many changed."""
    changed = 0
    for path in sorted((prefix / "share").rglob("*.cmake")):
        old = path.read_text(encoding="utf-8")
        new = relocated(old, headers, site_packages)
        if new != old:
            replace(path, new)
            changed += 1
    return changed


def main() -> int:
    """Relocate the environment this interpreter belongs to."""
    if sys.prefix == sys.base_prefix:
        print("relocate_ros_wheels.py: run me with the Python of a venv", file=sys.stderr)
        return 1
    headers = sysconfig.get_path("include")
    count = relocate(Path(sys.prefix), headers, sysconfig.get_path("purelib"))
    print(f"relocated {count} CMake files")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
