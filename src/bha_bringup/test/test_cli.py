"""The commands that start a graph, with nothing started."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from bha_bringup import cli
from bha_bringup.graph_processes import GraphError


def test_up_keeps_models_and_logs_in_one_folder(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Also where the shell does not expand it, as behind an equals sign."""
    started: list[Any] = []

    def start(*arguments: Any) -> None:
        started.extend(arguments)
        raise GraphError("enough")

    monkeypatch.setattr(cli, "refuse_second_graph", lambda: None)
    monkeypatch.setattr(cli, "GraphProcesses", start)
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    (tmp_path / "lab.yaml").touch()
    ran = CliRunner().invoke(cli.app, ["up", "--models=~/m", "--params-file=~/lab.yaml"])
    assert str(ran.exception) == "enough", ran.output
    nodes, logs, params_file = started
    files = {node.parameters["model_file"] for node in nodes if "model_file" in node.parameters}
    assert {Path(file).parent for file in files} == {tmp_path / "m"}
    assert logs == tmp_path / "m" / "logs"
    assert params_file == tmp_path / "lab.yaml"


@pytest.mark.parametrize(("call", "unit"), [(["reach"], "in m."), (["driver", "press"], "in Pa.")])
def test_help_tells_units(call: list[str], unit: str) -> None:
    """The terminal takes a word in square brackets for a style."""
    assert unit in CliRunner().invoke(cli.app, [*call, "--help"]).output
