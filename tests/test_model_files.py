"""Model files that cannot be used are refused with the reason, and the model in use stays."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bha_bringup.robot_connection import RobotError
from bha_common.files import save_versioned
from bha_goal_babbling.checkpoint import KIND as CHECKPOINT
from bha_goal_babbling.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from bha_pressure_ctrl.equilibrium_model import EquilibriumModel
from running_graph import GOAL, ROBOT, RunningGraph, StartGraph, refused_node

pytestmark = pytest.mark.graph

STEMS = {"pressure_ctrl": "equilibrium_model", "learner": "inverse_model"}
KINDS = {"pressure_ctrl": "equilibrium model", "learner": CHECKPOINT}
PACKAGES = {"pressure_ctrl": "bha_pressure_ctrl", "learner": "bha_goal_babbling"}

# --- what can be wrong with a file: each makes `path` out of the good file `good` ---------------


def _cut(path: Path, good: Path, _: str) -> None:
    path.write_bytes(good.read_bytes()[: good.stat().st_size // 2])


def _empty(path: Path, *_: object) -> None:
    path.write_bytes(b"")


def _altered(path: Path, good: Path, _: str) -> None:
    data = bytearray(good.read_bytes())
    data[len(data) // 2] ^= 0x10
    path.write_bytes(data)


def _other_version(path: Path, _: Path, node: str) -> None:
    save_versioned(path, kind=KINDS[node], version=99, robot=ROBOT, arrays={}, settings={})


def _other_kind(path: Path, good: Path, node: str) -> None:
    (other,) = set(STEMS.values()) - {STEMS[node]}
    shutil.copy(good.with_name(f"{other}.npz"), path)


def _other_robot(path: Path, good: Path, node: str) -> None:
    if node == "pressure_ctrl":
        EquilibriumModel.load(good, ROBOT).save(path, "bha_sim_7")
    else:
        save_checkpoint(path, load_checkpoint(good, robot=ROBOT), robot="bha_sim_7")


def _missing(path: Path, *_: object) -> None:
    path.unlink(missing_ok=True)


def _folder(path: Path, *_: object) -> None:
    path.mkdir()


FAULTS: dict[str, tuple[Callable[[Path, Path, str], None], str]] = {
    "cut": (_cut, "not a whole model file"),
    "empty": (_empty, "not a whole model file"),
    "altered": (_altered, "checksum|not a whole model file"),
    "other version": (_other_version, "version is 99, but [123] is needed"),
    "other kind": (_other_kind, "kind is"),
    "other robot": (_other_robot, "belongs to robot 'bha_sim_7', but this robot is 'bha_sim_0'"),
    "missing": (_missing, "there is no such file"),
    "folder": (_folder, "this is a folder"),
}


@pytest.fixture(scope="class")
def graph(start_shared_graph: StartGraph) -> RunningGraph:
    graph = start_shared_graph()
    graph.wait_robot(1.0)
    graph.client.reach(GOAL)
    return graph


class TestLoad:
    @pytest.mark.parametrize("node", STEMS)
    def test_refused_and_the_model_in_use_stays(
        self, graph: RunningGraph, trained: Path, tmp_path: Path, node: str
    ) -> None:
        before = graph.fresh(node)
        for fault, (make, reason) in FAULTS.items():
            path = tmp_path / f"{fault.replace(' ', '_')}.npz"
            make(path, trained / f"{STEMS[node]}.npz", node)
            with pytest.raises(RobotError, match=reason) as refusal:
                graph.client.load(node, str(path))
            assert "the model in use stays" in str(refusal.value)
            assert str(path) in str(refusal.value)
        # It still controls as before.
        after = graph.fresh(node)
        for key in ("mode", "model", "movements"):
            assert after.get(key) == before.get(key)
        goal = np.array([-0.1, 0.1, 0.78])
        result = graph.client.reach(goal)
        assert result.error < 0.06

    def test_of_another_task(self, graph: RunningGraph, trained: Path, tmp_path: Path) -> None:
        stored = load_checkpoint(trained / "inverse_model.npz", robot=ROBOT)
        path = tmp_path / "other_task.npz"
        save_checkpoint(path, Checkpoint(stored.babbler, "3d", 1.0), robot=ROBOT)
        with pytest.raises(RobotError, match="learned task '3d'; this learner's is '2d'"):
            graph.client.load("learner", str(path))

    @pytest.mark.parametrize("node", STEMS)
    def test_without_a_path_it_takes_the_models_file(self, graph: RunningGraph, node: str) -> None:
        wanted = graph.folder / "models" / f"{STEMS[node]}.npz"
        assert graph.client.load(node) == f"loaded {wanted}"


class TestSave:
    @pytest.mark.parametrize("node", STEMS)
    def test_where_nothing_can_be_written(
        self, graph: RunningGraph, tmp_path: Path, node: str
    ) -> None:
        occupied = tmp_path / "occupied"
        occupied.write_text("a file, not a folder")
        folder = tmp_path / "folder.npz"
        folder.mkdir()
        for path in (occupied / "model.npz", folder, Path("/proc/nothing/model.npz")):
            with pytest.raises(RobotError, match="cannot be written: ") as refusal:
                graph.client.save(node, str(path))
            assert str(path) in str(refusal.value)
        assert graph.fresh(node)["mode"]  # it lives
        assert sorted(entry.name for entry in tmp_path.iterdir()) == ["folder.npz", "occupied"]

    @pytest.mark.parametrize("node", STEMS)
    def test_a_folder_that_is_not_there_is_made(
        self, graph: RunningGraph, tmp_path: Path, node: str
    ) -> None:
        path = tmp_path / "new" / "folder" / "model.npz"
        assert graph.client.save(node, str(path)) == str(path)
        graph.client.load(node, str(path))
        assert [entry.name for entry in path.parent.iterdir()] == ["model.npz"]


@pytest.mark.parametrize("node", STEMS)
@pytest.mark.parametrize("fault", ["cut", "other version", "other robot"])
def test_a_node_does_not_start_with_a_broken_model(
    trained: Path, tmp_path: Path, node: str, fault: str
) -> None:
    """It ends with code 2 and the file's name, rather than forget what it was to go on with."""
    path = tmp_path / "model.npz"
    make, _ = FAULTS[fault]
    make(path, trained / f"{STEMS[node]}.npz", node)
    before = path.read_bytes()
    wrong = ("-p", f"robot:={ROBOT}", "-p", f"model_file:={path}")
    assert f"error: {path}: " in refused_node(PACKAGES[node], node, *wrong)
    assert path.read_bytes() == before
