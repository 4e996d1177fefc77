"""The inside of the emulated terminal, with a clock that the test turns."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from bha_driver.emulated_registers import EmulatedRegisters
from bha_driver.terminal_file import load_terminal

MAP = load_terminal()
FIRST, COUNT = MAP.output_block


class Bellows:
    """Bellows that never move."""

    state = SimpleNamespace(lengths=np.full(9, 0.2), pressures=np.zeros(9))

    def step(self, _: np.ndarray) -> SimpleNamespace:
        return self.state


@pytest.mark.parametrize("late", [False, True])
def test_a_write_does_not_hide_that_the_watchdog_has_vented(late: bool) -> None:
    clock = SimpleNamespace(time=0.0)
    registers = EmulatedRegisters(MAP, Bellows(), lambda: clock.time)
    assert MAP.watchdog.register is not None
    registers.write(MAP.watchdog.register, [MAP.watchdog.word])
    registers.write(FIRST, [100] * COUNT)
    clock.time += MAP.watchdog.time + (0.01 if late else -0.01)
    registers.write(FIRST, [110] * COUNT)
    assert registers.trips == int(late)
    assert registers.outputs == (110,) * COUNT
