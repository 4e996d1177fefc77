"""The commands for a graph that is up, with a robot in the place of the graph."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from bha_bringup import running_cli
from bha_bringup.robot_client import Reached
from bha_bringup.robot_connection import RobotError


class Robot:
    """Does what it is told at once; its nodes have no model files."""

    def __enter__(self) -> Robot:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def identify(self, *_: Any) -> SimpleNamespace:
        return SimpleNamespace(message="fitted to 60 samples")

    def babble(self, *_: Any, **__: Any) -> SimpleNamespace:
        return SimpleNamespace(message="explored for 60 s")

    def reach(self, goal: Any, **_: Any) -> Reached:
        success = bool(goal[0] > 0.0)
        message = "at rest" if success else "not at rest within the time"
        return Reached(success, message, goal, 0.0, 20.0)

    def save(self, node: str, path: str = "") -> str:
        if not path:
            raise RobotError(f"{node}: give a path, or set the parameter model_file")
        return path

    load = save


@pytest.fixture(autouse=True)
def _robot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running_cli, "RobotClient", Robot)


@pytest.mark.parametrize(
    ("command", "node", "result"),
    [
        ("identify", "pressure_ctrl", "fitted to 60 samples"),
        ("babble", "learner", "explored for 60 s"),
    ],
)
def test_what_cannot_be_saved_was_learned_all_the_same(
    command: str, node: str, result: str
) -> None:
    ran = CliRunner().invoke(running_cli.app, [command])
    assert ran.exit_code == 0, ran.output
    said = " ".join(ran.output.split())
    assert said.index(result) < said.index(f"not saved ({node}: give a path")
    assert "`bha save FOLDER` saves it" in said


@pytest.mark.parametrize("command", ["save", "load"])
@pytest.mark.parametrize(
    ("folder", "where"), [(".", "here"), ("~/mine", "home/mine"), ("/m", "/m")]
)
def test_a_folder_is_meant_as_a_shell_means_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, command: str, folder: str, where: str
) -> None:
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.setenv("COLUMNS", "1000")
    ran = CliRunner().invoke(running_cli.app, [command, folder])
    assert ran.exit_code == 0, ran.output
    assert f"pressure_ctrl: {tmp_path / where / 'equilibrium_model.npz'}\n" in ran.output
    assert f"learner: {tmp_path / where / 'inverse_model.npz'}\n" in ran.output


@pytest.mark.parametrize("command", ["save", "load"])
def test_without_a_folder_a_node_takes_its_own_file(command: str) -> None:
    ran = CliRunner().invoke(running_cli.app, [command])
    assert "give a path" in str(ran.exception)


@pytest.mark.parametrize(
    ("x", "code", "message"), [("0.1", 0, "at rest"), ("-0.1", 1, "not at rest within the time")]
)
def test_a_script_sees_whether_a_goal_was_reached(x: str, code: int, message: str) -> None:
    ran = CliRunner().invoke(running_cli.app, ["reach", x, "0.1", "0.76"])
    assert ran.exit_code == code
    assert ran.output.startswith(f"{message} after 20.0 s: tip at ")
