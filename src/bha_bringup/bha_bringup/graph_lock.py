"""Knows which process has started the graph in a ROS domain, so that another can end it."""

from __future__ import annotations

import os
import signal
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bha_common.files import atomic_write

_PATIENCE = 10.0  # [s]


@contextmanager
def owning_graph() -> Iterator[None]:
    """Note, while the context is open, that this process owns the graph of its ROS domain."""
    path = _file()
    atomic_write(path, str(os.getpid()).encode())
    try:
        yield
    finally:
        path.unlink(missing_ok=True)


def stop_owner() -> bool:
    """End the process that owns the graph of this ROS domain; False when there is none."""
    pid = _owner()
    if pid is None:
        return False
    os.kill(pid, signal.SIGTERM)
    deadline = time.monotonic() + _PATIENCE
    while _owner() == pid and time.monotonic() < deadline:
        time.sleep(0.05)
    return _owner() != pid


def _owner() -> int | None:
    try:
        pid = int(_file().read_text())
        command = Path(f"/proc/{pid}/cmdline").read_bytes()
    except (OSError, ValueError):
        return None
    # The number may be that of another process by now.
    return pid if b"bha" in command else None


def _file() -> Path:
    folder = os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()
    domain = os.environ.get("ROS_DOMAIN_ID", "0")
    return Path(folder, f"bha-graph-{os.getuid()}-{domain}.pid")
