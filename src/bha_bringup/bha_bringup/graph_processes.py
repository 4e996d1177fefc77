"""Runs the nodes of a graph as processes, and ends every one of them."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

import yaml
from ament_index_python.packages import get_package_prefix

from bha_bringup.graph import NAMESPACE, NodeDescription

_GRACE = 5.0  # [s] from the request to end until the process is killed


class GraphError(RuntimeError):
    """The graph cannot be started or has lost a node; the message says which and why."""


class GraphProcesses:
    """The processes of a graph; a context manager that leaves none behind.

    Parameters
    ----------
    nodes : What to run.
    folder : Where the parameters and the logs of the nodes are written.
    params_file : Parameters of the user, which go before those of the description.
    """

    def __init__(
        self, nodes: Sequence[NodeDescription], folder: Path, params_file: Path | None = None
    ) -> None:
        self._nodes = {node.executable: node for node in nodes}
        self._folder = folder
        self._params_file = params_file
        self._processes: dict[str, subprocess.Popen[bytes]] = {}

    def __enter__(self) -> GraphProcesses:
        try:
            for name in self._nodes:
                self.start(name)
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def start(self, name: str) -> None:
        """Start one node, at the beginning or again after it has ended."""
        node = self._nodes[name]
        executable = Path(get_package_prefix(node.package), "lib", node.package, node.executable)
        if not executable.exists():
            raise GraphError(f"{executable} is missing: build the workspace first")
        self._folder.mkdir(parents=True, exist_ok=True)
        parameters = self._folder / f"{name}.yaml"
        # Where the description leaves a value open, the node's default holds.
        known = {key: value for key, value in node.parameters.items() if value != ""}
        parameters.write_text(yaml.safe_dump({"/**": {"ros__parameters": known}}))
        files = [parameters] + ([self._params_file] if self._params_file else [])
        arguments = [part for file in files for part in ("--params-file", str(file))]
        with (self._folder / f"{name}.log").open("ab") as log:
            process = subprocess.Popen(
                [str(executable), "--ros-args", "-r", f"__ns:={NAMESPACE}", *arguments],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,  # Ctrl-C reaches us alone; we end the nodes in order
            )
        self._processes[name] = process
        if node.in_loop is not None:
            _place(process.pid, in_loop=node.in_loop)

    def pid(self, name: str) -> int:
        """Process id of a node."""
        return self._processes[name].pid

    def check(self) -> None:
        """Raise GraphError when a node has ended by itself."""
        for name, process in self._processes.items():
            code = process.poll()
            if code is not None:
                log = self._folder / f"{name}.log"
                tail = "\n".join(log.read_text(errors="replace").splitlines()[-5:])
                raise GraphError(f"{name} has ended with code {code}; its log {log} says:\n{tail}")

    def stop(self) -> None:
        """End every process: asked first, so that the learner keeps what it learned, then made."""
        for process in reversed(self._processes.values()):
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        deadline = time.monotonic() + _GRACE
        for process in self._processes.values():
            try:
                process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._processes.clear()


def _place(pid: int, *, in_loop: bool) -> None:
    """Keep the nodes that wait for one another on one core.

    Waking a process on another core that has gone to sleep costs more than the work itself: on two
    cores this makes lockstep 1.4 times as fast.
    """
    cores = sorted(os.sched_getaffinity(0))
    if len(cores) > 1:
        os.sched_setaffinity(pid, {cores[0]} if in_loop else set(cores[1:]))
