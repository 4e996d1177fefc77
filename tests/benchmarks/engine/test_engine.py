"""How tables are made: stored, resumed, on other processes, with bounds that are told."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from dask.distributed import LocalCluster
from typer.testing import CliRunner

from benchmarks import tables
from benchmarks.__main__ import app
from benchmarks.arm import linear
from benchmarks.engine import execution, plain_json, provenance, results
from benchmarks.engine.execution import Job, OtherCodeError, on_a_cluster, on_this_machine
from benchmarks.engine.experiment import Bound, Experiment, Figures, Run, Summary
from benchmarks.engine.run_store import RunStore, StoredRun

ROOT = Path(__file__).parents[3]
made: list[tuple[int, int]] = []


def square(seed: int, *, number: int) -> Figures:
    """Stand in for a run: quick, and it tells that it was made."""
    made.append((seed, number))
    if number < 0:
        raise ZeroDivisionError("a run that fails")
    return {"square": np.float64(number**2 + seed), "list": np.arange(2)}


def summary(runs: Sequence[Run]) -> Summary:
    worst = max(run.figures["square"] for run in runs)
    rows = [{"number": run.settings["number"], "square [m]": run.figures["square"]} for run in runs]
    return Summary(rows, [Bound.at_most("largest square", 1e4, worst)], "a note")


def squares(numbers: Sequence[int]) -> Experiment:
    """Return a table of squares."""
    return Experiment(
        name="toy",
        claim="squares grow",
        shows="squares",
        minutes=0.1,
        seeds=3,
        plan=lambda quick: [{"number": number} for number in numbers[: 1 if quick else None]],
        run=square,
        summarise=summary,
        draw=lambda runs, figure: figure.subplots().plot([run.seed for run in runs]),
    )


@pytest.fixture(autouse=True)
def forget() -> None:
    made.clear()


@pytest.fixture
def order(tmp_path: Path) -> results.Order:
    return results.Order(seeds=2, jobs=1, out=tmp_path)


def silent(done: int, total: int) -> None:
    """Show nothing."""


# --- what a table is ---------------------------------------------------------------------------


def test_the_json_holds_what_was_promised(order: results.Order) -> None:
    told = []
    result = results.make_table(squares([2, 3]), order, lambda *counts: told.append(counts))
    assert told == [(0, 4), (1, 4), (2, 4), (3, 4), (4, 4)]
    content = json.loads((order.out / "toy.json").read_text())
    assert content == result.content
    assert content["rows"][0] == {"number": 2, "square [m]": 1004.0}
    assert content["bounds"] == [
        {"what": "largest square", "bound": "<= 10000", "measured": 1010.0, "holds": True}
    ]
    assert [(run["seed"], run["settings"]["number"]) for run in content["runs"]] == [
        (1000, 2),
        (1000, 3),
        (1001, 2),
        (1001, 3),
    ]
    assert content["runs"][0]["figures"] == {"square": 1004.0, "list": [0, 1]}
    assert (content["settings"], content["seeds"]) == ([{"number": 2}, {"number": 3}], [1000, 1001])
    assert {"python", "numpy", "numba", "code"} <= content["versions"].keys()
    assert (order.out / "toy.png").read_bytes().startswith(b"\x89PNG")


def test_numbers_that_are_none_are_null_in_the_json(tmp_path: Path) -> None:
    """Python's own NaN in JSON is not JSON."""
    plain_json.write(tmp_path / "a.json", {"x": [np.nan, np.inf, np.float32(0.5), np.True_]})
    assert json.loads((tmp_path / "a.json").read_text()) == {"x": [None, None, 0.5, True]}
    with pytest.raises(TypeError, match="Path"):
        plain_json.write(tmp_path / "b.json", {"x": tmp_path})


def test_quick_takes_few_seeds_and_its_own_plan(order: results.Order) -> None:
    results.make_table(squares([2, 3]), replace(order, quick=True, seeds=None), silent)
    assert made == [(1000, 2), (1001, 2)]


# --- resuming ----------------------------------------------------------------------------------


def test_what_was_made_is_not_made_again(order: results.Order) -> None:
    first = results.make_table(squares([2, 3]), order, silent)
    again = results.make_table(squares([2, 3, 4]), order, silent)
    assert made == [(1000, 2), (1000, 3), (1001, 2), (1001, 3), (1000, 4), (1001, 4)]
    assert again.content["runs"][0] == first.content["runs"][0]


def test_a_run_that_fails_costs_no_other(order: results.Order) -> None:
    with pytest.raises(ZeroDivisionError):
        results.make_table(squares([2, -1]), order, silent)
    assert not (order.out / "toy.json").exists()
    made.clear()
    results.make_table(squares([2]), replace(order, seeds=1), silent)
    assert made == []


def test_runs_of_other_code_are_not_used(
    order: results.Order, monkeypatch: pytest.MonkeyPatch
) -> None:
    results.make_table(squares([2]), order, silent)
    for module in (results, execution):
        monkeypatch.setattr(module, "fingerprint", lambda module: "another")
    results.make_table(squares([2]), order, silent)
    assert made == 2 * [(1000, 2), (1001, 2)]


@pytest.mark.parametrize(
    ("edited", "matters"),
    [
        ("benchmarks.arm.linear", True),
        ("benchmarks.arm.linear_babbling", True),
        ("bha_goal_babbling.recursive_maps", True),
        ("benchmarks.arm.drift", False),
        ("benchmarks.engine.page", False),
        ("bha_sim.plant", False),
    ],
)
def test_the_code_behind_a_table_is_what_it_imports(
    edited: str, matters: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = provenance.fingerprint("benchmarks.arm.linear")
    source = provenance._source(edited)
    other = tmp_path / source.name
    other.write_bytes(source.read_bytes() + b"# edited\n")
    find = provenance._source
    monkeypatch.setattr(
        provenance, "_source", lambda module: other if module == edited else find(module)
    )
    after = provenance.fingerprint.__wrapped__("benchmarks.arm.linear")
    assert (after != before) == matters


@pytest.mark.parametrize(("package", "matters"), [("bha_sim", True), ("bha_driver", False)])
def test_the_settings_of_the_packages_behind_a_table_belong_to_it(
    package: str, matters: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = provenance.fingerprint("benchmarks.trunk.bha_learning")
    source = provenance._source(package)
    copy = tmp_path / package
    shutil.copytree(source.parents[1] / "config", copy / "config")
    with next((copy / "config").glob("*.yaml")).open("a") as stream:
        stream.write("# edited\n")
    find = provenance._source
    monkeypatch.setattr(
        provenance,
        "_source",
        lambda name: copy / package / source.name if name == package else find(name),
    )
    after = provenance.fingerprint.__wrapped__("benchmarks.trunk.bha_learning")
    assert (after != before) == matters


def test_a_line_that_was_cut_off_spoils_no_other(tmp_path: Path) -> None:
    path = tmp_path / "runs.jsonl"
    kept = [StoredRun(Run(seed, {"a": 1, "b": (2,)}, {"x": 0.1 * seed}), 1.0) for seed in (1, 2, 3)]
    RunStore(path, "code").add(kept[0])
    RunStore(path, "code").add(kept[1])
    path.write_text(path.read_text()[:-9])
    RunStore(path, "code").add(kept[2])
    store = RunStore(path, "code")
    found = [store.get(seed, {"b": [2], "a": 1}) for seed in (1, 2, 3)]
    assert found[1] is None
    assert [run and run.run.figures for run in (found[0], found[2])] == [
        {"x": 0.1},
        {"x": 0.1 * 3},
    ]
    assert RunStore(path, "other").get(1, {"a": 1, "b": [2]}) is None


def test_ctrl_c_keeps_what_was_made(tmp_path: Path) -> None:
    """A run ends, Ctrl-C comes, and the same command goes on after that run."""
    command = [sys.executable, "-m", "benchmarks", "linear", "--jobs", "1", "--out", str(tmp_path)]
    runs = tmp_path / ".runs" / "linear.jsonl"
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"TERM": "dumb"},
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )  # a shell lets what it runs in the background, such as these tests, ignore Ctrl-C
    deadline = time.monotonic() + 120
    while not runs.exists() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    output, _ = process.communicate(timeout=60)
    assert process.returncode == 130, output
    assert "are kept" in output
    store = RunStore(runs, provenance.fingerprint("benchmarks.arm.linear"))
    assert store.get(1000, dict(linear.plan(False)[0])) is not None


# --- other processes ---------------------------------------------------------------------------

PART: dict[str, Any] = {"part": "gradients", "problems": 3}


def jobs(fingerprint: str) -> list[Job]:
    return [Job(linear.run, seed, PART, fingerprint) for seed in range(4)]


def figures(stored: Iterator[StoredRun]) -> dict[int, Figures]:
    return {each.run.seed: each.run.figures for each in stored}


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None
    ) as running:
        yield running


def test_every_way_of_making_runs_brings_the_same(cluster: LocalCluster) -> None:
    """In this process, on two others, and on a Dask cluster."""
    wanted = jobs(provenance.fingerprint("benchmarks.arm.linear"))
    here = figures(on_this_machine(wanted, 1))
    assert sorted(here) == [0, 1, 2, 3]
    assert here[0] != here[1]
    assert figures(on_this_machine(wanted, 2)) == here
    assert figures(on_a_cluster(wanted, cluster.scheduler_address)) == here


def test_a_worker_with_other_code_is_refused(cluster: LocalCluster) -> None:
    with pytest.raises(OtherCodeError, match="checkout"):
        figures(on_a_cluster(jobs("another"), cluster.scheduler_address))


# --- the command -------------------------------------------------------------------------------


def test_a_wrong_name_tells_the_right_ones() -> None:
    with pytest.raises(tables.UnknownTableError, match=r"'line'; there are toy, .*linear"):
        tables.find("line")


@pytest.mark.parametrize("name", tables.NAMES)
def test_tables_have_the_names_they_are_found_by(name: str) -> None:
    assert tables.find(name).name == name


def test_list_tells_all_that_there_are() -> None:
    output = CliRunner().invoke(app, ["list"]).output
    assert all(name in output for name in tables.NAMES)


@pytest.mark.parametrize(("number", "status"), [(2, 0), (200, 1)])
def test_a_missed_bound_is_told(
    number: int, status: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("benchmarks.__main__.find", lambda name: squares([number]))
    result = CliRunner().invoke(app, ["toy", "--jobs", "1", "--out", str(tmp_path)])
    assert result.exit_code == status, result.output
    assert "squares grow" in result.output
    assert "square [m]" in result.output
    assert ("toy: largest square <= 10000" in result.output) == bool(status)


def test_quick_runs_need_not_tell_every_bound(order: results.Order) -> None:
    """What is not measured is missed in full runs alone."""
    untold = replace(
        squares([2]), summarise=lambda runs: Summary([{}], [Bound.at_most("long", 1.0, None)])
    )
    assert results.make_table(untold, order, silent).missed
    assert not results.make_table(untold, replace(order, quick=True), silent).missed
