"""A demonstration leaves a graph that runs already as it is."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from bha_bringup import demo, graph_lock
from bha_bringup.cli import app
from bha_bringup.robot_connection import RobotError


def test_a_graph_that_runs_keeps_its_models_and_its_owner(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def refuse() -> None:
        raise RobotError("a graph is running")

    monkeypatch.setattr(demo, "refuse_second_graph", refuse)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    kept = [
        graph_lock._file(),
        tmp_path / "out/models/equilibrium_model.npz",
        tmp_path / "out/models/inverse_model.npz",
    ]
    (tmp_path / "out/models").mkdir(parents=True)
    for path in kept:
        path.write_text("of the other graph")
    result = CliRunner().invoke(app, ["demo", "--out", str(tmp_path / "out")])
    assert isinstance(result.exception, RobotError)
    for path in kept:
        assert path.read_text() == "of the other graph"
    assert not (tmp_path / "out/results.json").exists()
