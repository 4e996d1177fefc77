"""When the faults of a schedule begin and end."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from bha_driver.fault_player import FaultPlayer
from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.terminal_file import load_terminal
from bha_driver.wire_faults import parse_faults


class Bellows:
    """Bellows that never move."""

    state = SimpleNamespace(lengths=np.full(9, 0.2), pressures=np.zeros(9))

    def step(self, _: np.ndarray) -> SimpleNamespace:
        return self.state


def test_one_of_a_kind_ends_while_another_goes_on() -> None:
    with TerminalEmulator(load_terminal(), Bellows()) as emulator:
        player = FaultPlayer(emulator, parse_faults("delay@10+5, delay@12+1, drop@14+1"))
        seen = []
        for tenth in range(90, 160):
            player.advance(tenth / 10)
            seen.append(set(emulator.faults))
    assert seen[:10] == [set()] * 10
    assert seen[10:50] == [{"delay"}] * 40
    assert seen[50:60] == [{"delay", "drop"}] * 10
    assert seen[60:] == [set()] * 10
    assert player.done
