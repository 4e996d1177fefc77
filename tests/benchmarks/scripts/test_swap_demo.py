"""The comparison of the two demonstrations, without running them."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from benchmarks.scripts import swap_demo
from benchmarks.scripts.swap_demo import Comparison, plan, stored
from bha_bringup.demo_record import DemoRecord, GoalRecord
from bha_bringup.demo_settings import DemoSettings

ONE_EACH = {"sim": 1, "hardware-emulated": 1}


def test_runs_of_a_seed_differ_by_the_robot_alone(tmp_path: Path) -> None:
    planned = plan([3, 4], 5.0, 30, tmp_path, {"sim": 3, "hardware-emulated": 1})
    first, *_, second = planned[:4]
    assert (first.robot, second.robot) == ("sim", "hardware-emulated")
    for name in ("space", "minutes", "seed", "goals", "identification_samples"):
        assert getattr(first, name) == getattr(second, name)
    assert [settings.seed for settings in planned] == [3] * 4 + [4] * 4
    assert len({settings.out for settings in planned}) == 8


@pytest.mark.parametrize(
    ("factor", "holds"), [(1.19, True), (1.21, False), (0.81, True), (0.7, False)]
)
def test_the_bound_holds_both_ways(factor: float, holds: bool) -> None:
    errors = np.linspace(0.002, 0.02, 30).reshape(2, 15)
    one = Comparison(errors, factor * errors)
    assert one.holds is holds
    assert one.difference == pytest.approx(factor - 1.0)


def test_the_standard_error_is_that_of_other_runs() -> None:
    rng = np.random.default_rng(0)
    found = []
    for _ in range(4000):
        means = 0.006 * rng.normal(1.0, 0.1, (12, 1)) * np.ones(30)
        found.append(Comparison(means[:8], means[8:]))
    spread = np.std([one.difference for one in found])
    assert np.mean([one.standard_error for one in found]) == pytest.approx(spread, rel=0.1)
    assert np.isnan(Comparison(*np.ones((2, 1, 30))).standard_error), "one run tells nothing of it"


def record(settings: DemoSettings, error: float) -> DemoRecord:
    goals = [
        GoalRecord(np.zeros(3), feedforward_error=error, feedback_error=0.1 * error)
        for _ in range(settings.goals)
    ]
    return DemoRecord(settings, exploration_minutes=settings.minutes, goals=goals, complete=True)


def test_what_is_done_is_taken_over_when_it_is_the_same(tmp_path: Path) -> None:
    settings, *_ = plan([0], 5.0, 4, tmp_path, ONE_EACH)
    assert stored(settings) is None
    settings.out.mkdir()
    record(settings, 0.01).write(settings.out)
    found = stored(settings)
    assert found is not None
    assert found["feedforward"] == pytest.approx(np.full(4, 0.01))
    assert stored(plan([0], 6.0, 4, tmp_path, ONE_EACH)[0]) is None, "other minutes"
    assert stored(plan([0], 5.0, 5, tmp_path, ONE_EACH)[0]) is None, "other goals"
    cut = json.loads((settings.out / "results.json").read_text()) | {"complete": False}
    (settings.out / "results.json").write_text(json.dumps(cut))
    assert stored(settings) is None, "broken off"


@pytest.mark.parametrize(("behind", "code"), [(0.011, 0), (0.013, 1)])
def test_it_says_whether_the_bound_holds(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    behind: float,
    code: int,
) -> None:
    def run(settings: DemoSettings, _: object) -> dict[str, np.ndarray]:
        error = 0.01 if settings.robot == "sim" else behind
        settings.out.mkdir()
        record(settings, error).write(settings.out)
        return {kind: record(settings, error).errors(kind) for kind in swap_demo.KINDS}

    monkeypatch.setattr(swap_demo, "measure", run)
    arguments = ["--seeds", "0", "--simulated", "3", "--emulated", "1", "--out", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", ["swap_demo", *arguments])
    with pytest.raises(SystemExit) as ended:
        swap_demo.main()
    assert ended.value.code == code
    shown = capsys.readouterr().out
    assert ("within 20%: all" in shown) is (code == 0)
    assert "simulator 10.0 (10.0 10.0 10.0)" in shown
    assert shown.count("0 movements, 0 samples, 0 maps") == 4


@pytest.mark.parametrize("kind", ["--simulated", "--emulated"])
def test_no_runs_are_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    monkeypatch.setattr(sys, "argv", ["swap_demo", kind, "0"])
    with pytest.raises(SystemExit):
        swap_demo.main()
    assert "--simulated and --emulated must be at least 1" in capsys.readouterr().err
