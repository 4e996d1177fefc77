"""Compiled functions compute what their Python text says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from bha_sim import pneumatics, potentiometers


def _arguments(name: str) -> tuple[Any, list[Any]]:
    rng = np.random.default_rng(1)
    nine = lambda: rng.normal(0.0, 1.0, 9)  # noqa: E731
    if name == "pneumatics._advance":
        waiting = rng.uniform(0.0, 1.0, (3, 9))
        speeds = [abs(nine()) for _ in range(3)]
        ends = [np.full(9, -0.5), np.full(9, 0.5)]
        stuck = np.arange(9) % 3 == 0
        arguments = [nine(), waiting, 2, 0.1, *speeds, *ends, stuck, nine(), nine()]
        return pneumatics._advance, arguments
    if name == "pneumatics._read":
        return pneumatics._read, [nine(), 0.1, 0.25, nine()]
    normals = rng.normal(0.0, 1.0, (2, 9))
    numbers = [0.1, 0.9, 0.2, 0.3, 0.05]
    arguments = [nine(), normals, *numbers, *(nine() for _ in range(8))]
    return potentiometers._read, arguments


@pytest.mark.parametrize(
    "name", ["pneumatics._advance", "pneumatics._read", "potentiometers._read"]
)
def test_to_a_rounding(name):
    # The compiler may contract a*b + c into one rounding, so the last bit is free.
    function, fast = _arguments(name)
    _, slow = _arguments(name)
    assert function(*fast) == function.py_func(*slow)
    for one, other in zip(fast, slow, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-14, atol=1e-15)
