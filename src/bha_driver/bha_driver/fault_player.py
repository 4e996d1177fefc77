"""Begins and ends the faults of a schedule when their time has come."""

from __future__ import annotations

from collections.abc import Sequence

from bha_driver.terminal_emulator import TerminalEmulator
from bha_driver.wire_faults import Fault


class FaultPlayer:
    """Plays a schedule on an emulated terminal.

    Parameters
    ----------
    emulator : Where the faults happen.
    faults : The schedule, in the order of their begins.
    """

    def __init__(self, emulator: TerminalEmulator, faults: Sequence[Fault]) -> None:
        self._emulator = emulator
        self._coming = list(faults)
        self._present: list[Fault] = []

    @property
    def done(self) -> bool:
        """Whether all faults have begun and ended."""
        return not self._coming and not self._present

    def advance(self, time: float) -> list[str]:
        """Let the time be `time` [s] after the begin; the names of faults that begin now."""
        before = {fault.name for fault in self._present}
        self._present = [fault for fault in self._present if time < fault.at + fault.duration]
        # One of a kind may end while another goes on.
        for name in before - {fault.name for fault in self._present}:
            self._emulator.end(name)
        begun = []
        while self._coming and time >= self._coming[0].at:
            fault = self._coming.pop(0)
            self._emulator.begin(fault.name)
            self._present.append(fault)
            begun.append(fault.name)
        return begun
