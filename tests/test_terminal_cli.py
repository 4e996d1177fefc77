"""`bha terminal` as a person uses it, against an emulated terminal."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from bha_bringup.terminal_cli import app
from bha_common.bellows import NAMES
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.terminal_file import example_path, load_terminal, parse_terminal

TEXT = example_path("cpx_e").read_text()
TRUE = load_terminal(example_path("cpx_e"))


class Bellows:
    """Bellows that a person holds."""

    def __init__(self) -> None:
        self.state = SimpleNamespace(lengths=np.full(9, 0.2), pressures=np.zeros(9))

    def step(self, pressures: np.ndarray) -> SimpleNamespace:
        return self.state


@pytest.fixture
def bellows() -> Bellows:
    return Bellows()


@pytest.fixture
def emulator(bellows: Bellows) -> Iterator[TerminalEmulator]:
    with TerminalEmulator(TRUE, bellows) as running:
        yield running


@pytest.fixture
def lab(emulator: TerminalEmulator, tmp_path: Path) -> Path:
    """A lab's map: patient, and with a potentiometer whose scale nobody has measured."""
    text = TEXT.replace("192.168.1.1", "127.0.0.1").replace("port: 502", f"port: {emulator.port}")
    text = text.replace("request: 0.02 ", "request: 0.5 ").replace("link: 0.06 ", "link: 0.6 ")
    text = text.replace("time: 0.2 ", "time: 2.0 ")
    assert parse_terminal(text).timeouts.request == 0.5
    file = tmp_path / "my_lab.yaml"
    file.write_text(text)
    return file


def test_check_reads_and_never_writes(lab: Path, emulator: TerminalEmulator) -> None:
    result = CliRunner().invoke(app, ["check", str(lab)])
    assert result.exit_code == 0, result.output
    assert "no problem seen; nothing was written" in result.output
    assert "bellows_3_3" in result.output
    assert not emulator.registers.writes
    assert not emulator.registers.armed


def test_check_ends_with_an_error_when_something_is_wrong(
    lab: Path, emulator: TerminalEmulator, bellows: Bellows
) -> None:
    bellows.state.lengths = np.full(9, 0.2)
    bellows.state.lengths[1] = 0.02
    emulator.step()
    result = CliRunner().invoke(app, ["check", str(lab)])
    assert result.exit_code == 1
    assert "problem: bellows_1_2 seems to be 0.0200 m long" in result.output


def test_calibrate_finds_scale_and_offset(
    lab: Path, emulator: TerminalEmulator, bellows: Bellows, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = lab.read_text().replace("offset: 0.0}", "offset: 0.05}", 1)
    lab.write_text(wrong)

    def hold(prompt: str, **_: object) -> str:
        """Hold the bellows at the length that is told; first too near, then no number."""
        answer = next(answers)
        if answer and answer != "long":
            bellows.state.lengths = np.full(9, 0.2)
            bellows.state.lengths[0] = float(answer) * 1e-3
            emulator.step()
        return answer

    answers = iter(["150", "160", "long", "150", "280"])
    monkeypatch.setattr("typer.prompt", hold)
    result = CliRunner().invoke(app, ["calibrate", str(lab), "--only", "bellows_1_1"])
    assert result.exit_code == 0, result.output
    assert "10 mm apart; at least 30 mm are needed; once more" in result.output
    assert "'long' is no number" in result.output
    found, true = load_terminal(lab).bellows[0].length, TRUE.bellows[0].length
    assert found.scale == pytest.approx(true.scale, rel=1e-3)
    assert found.offset == pytest.approx(true.offset, abs=1e-4)
    assert load_terminal(lab).bellows[1:] == TRUE.bellows[1:]
    assert "# CPX-E with analog modules" in lab.read_text(), "comments stay"
    assert not emulator.registers.writes


def test_calibrate_leaves_out_what_is_not_answered(lab: Path) -> None:
    before = lab.read_text()
    result = CliRunner().invoke(app, ["calibrate", str(lab)], input="\n" * len(NAMES))
    assert result.exit_code == 0, result.output
    assert result.output.count("left as it is") == len(NAMES)
    assert lab.read_text() == before


def test_calibrate_refuses_a_bellows_that_is_none(lab: Path) -> None:
    result = CliRunner().invoke(app, ["calibrate", str(lab), "--only", "bellows_9_9"])
    assert isinstance(result.exception, ValueError)
    assert "bellows_9_9 is no bellows; there are bellows_1_1" in str(result.exception)
