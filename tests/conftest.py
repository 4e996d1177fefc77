"""What the system tests share: graphs in ROS domains of their own, and models to start with."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

sys.path.insert(0, str(Path(__file__).parent))
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")

from bha_bringup.graph import GraphSettings
from bha_bringup.in_process import InProcessRobot
from bha_goal_babbling.checkpoint import Checkpoint, save_checkpoint
from bha_goal_babbling.task import find_task
from running_graph import ROBOT, RUNNING, RunningGraph, StartGraph, describe


def pytest_configure() -> None:
    """Let a run that is terminated, as by `timeout`, end its nodes as Ctrl-C does."""
    signal.signal(signal.SIGTERM, signal.default_int_handler)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
    """Show the tail of every node's log where a test has failed."""
    outcome = yield
    report = outcome.get_result()  # type: ignore[attr-defined]
    if report.failed:
        for graph in RUNNING:
            for name in sorted(graph.names):
                report.sections.append((f"log of {name}", graph.log(name)))


@pytest.fixture(scope="session")
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the models of a robot that was identified and has explored for 3 minutes."""
    folder = tmp_path_factory.mktemp("trained")
    robot = InProcessRobot(find_task("2d"), seed=0)
    robot.identify(24).save(folder / "equilibrium_model.npz", ROBOT)
    robot.babble(180.0)
    babbler = robot.learner.babbler
    assert babbler is not None
    save_checkpoint(
        folder / "inverse_model.npz",
        Checkpoint(babbler, "2d", robot.learner.exploration_time),
        robot=ROBOT,
    )
    return folder


def _graphs(trained: Path, folder: Path, stack: contextlib.ExitStack) -> StartGraph:
    def start(
        *,
        models: Sequence[str] = ("equilibrium_model", "inverse_model"),
        only: Sequence[str] = (),
        parameters: dict[str, dict[str, Any]] | None = None,
        **settings: Any,
    ) -> RunningGraph:
        """Start the graph of seed 0, in lockstep if not told otherwise."""
        chosen = GraphSettings(**{"real_time_factor": 0.0, "models": folder / "models", **settings})
        (folder / "models").mkdir(exist_ok=True)
        for stem in models:
            shutil.copy(trained / f"{stem}.npz", folder / "models")
        nodes = describe(chosen, only=only, parameters=parameters)
        return stack.enter_context(RunningGraph(nodes, folder))

    return start


@pytest.fixture
def start_graph(trained: Path, tmp_path: Path) -> Iterator[StartGraph]:
    """Starts a graph for one test; it ends with the test."""
    with contextlib.ExitStack() as stack:
        yield _graphs(trained, tmp_path, stack)


@pytest.fixture(scope="class")
def start_shared_graph(
    trained: Path, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[StartGraph]:
    """Starts a graph for a class of tests that do not disturb one another."""
    with contextlib.ExitStack() as stack:
        yield _graphs(trained, tmp_path_factory.mktemp("graph"), stack)
