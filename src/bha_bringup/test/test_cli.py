"""The commands that start a graph, with nothing started."""

from __future__ import annotations

import signal
import sys
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from bha_bringup import cli, demo
from bha_bringup.demo_record import DemoRecord
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


@pytest.mark.parametrize(
    ("given", "minutes", "goals", "samples"),
    [
        ([], 30.0, 25, 40),
        (["--quick"], 5.0, 5, 20),
        (["--quick", "--minutes", "2"], 2.0, 5, 20),
        (["--goals", "7", "--quick"], 5.0, 7, 20),
    ],
)
def test_a_demonstration_is_as_long_as_it_is_told(
    monkeypatch: pytest.MonkeyPatch, given: list[str], minutes: float, goals: int, samples: int
) -> None:
    def run(record: DemoRecord, _: Any) -> None:
        settings = record.settings
        assert (settings.minutes, settings.goals) == (minutes, goals)
        assert settings.identification_samples == samples
        raise GraphError("enough")

    monkeypatch.setattr(cli, "run_demo", run)
    assert str(CliRunner().invoke(cli.app, ["demo", *given]).exception) == "enough"


@pytest.mark.parametrize("command", [["demo", "--out"], ["up", "--models"]])
def test_a_folder_that_cannot_be_made_is_named(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    command: list[str],
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setattr(cli, "refuse_second_graph", lambda: None)
    monkeypatch.setattr(demo, "refuse_second_graph", lambda: None)
    monkeypatch.setattr(signal, "signal", lambda *_: None)
    monkeypatch.setattr(sys, "argv", ["bha", *command, str(tmp_path / "file" / "x")])
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 1
    said = "".join(capsys.readouterr().out.split())
    assert "Notadirectory" in said
    assert f"{tmp_path}/file/x/" in said


@pytest.mark.parametrize(("call", "unit"), [(["reach"], "in m."), (["driver", "press"], "in Pa.")])
def test_help_tells_units(call: list[str], unit: str) -> None:
    """The terminal takes a word in square brackets for a style."""
    assert unit in CliRunner().invoke(cli.app, [*call, "--help"]).output
