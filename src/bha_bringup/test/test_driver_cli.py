"""`bha driver press`: one bellows by hand."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

from bha_bringup import driver_cli


class Robot:
    """Takes what is pressed."""

    pressed: tuple[np.ndarray, float] | None = None

    def __enter__(self) -> Robot:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    def press(self, pressures: np.ndarray, duration: float) -> np.ndarray:
        Robot.pressed = pressures, duration
        return np.linspace(0.2, 0.28, 9)


def test_one_bellows_is_pressed_and_its_length_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(driver_cli, "RobotClient", Robot)
    arguments = ["press", "bellows_2_1", "2e4", "--seconds", "1.5"]
    result = CliRunner().invoke(driver_cli.app, arguments)
    assert result.exit_code == 0, result.output
    assert Robot.pressed is not None
    pressures, duration = Robot.pressed
    assert pressures.tolist() == [0, 0, 0, 2e4, 0, 0, 0, 0, 0]
    assert duration == 1.5
    assert "bellows_2_1 is 0.2300 m long" in result.output


def test_a_bellows_that_is_none_is_refused() -> None:
    result = CliRunner().invoke(driver_cli.app, ["press", "bellows_9_9"])
    assert isinstance(result.exception, ValueError)
    assert "bellows_9_9 is no bellows; there are bellows_1_1" in str(result.exception)
