"""The commands for a graph that is up, with a robot in the place of the graph."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

from bha_bringup import running_cli
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

    def save(self, node: str, path: str = "") -> str:
        if not path:
            raise RobotError(f"{node}: give a path, or set the parameter model_file")
        return path


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
