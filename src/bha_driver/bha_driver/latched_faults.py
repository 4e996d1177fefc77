"""What holds the driver in its safe state: latched until an explicit reset."""

from __future__ import annotations

from dataclasses import dataclass

EMERGENCY_STOP = "emergency stop"
LINK_LOST = "connection lost"
RESTARTED = "terminal restarted"
OVERSLEPT = "writes overdue"


@dataclass(frozen=True)
class Fault:
    """Why the driver is in its safe state.

    Attributes
    ----------
    which : The kind, such as ``connection lost``.
    why : What was seen.
    time : When [s].
    """

    which: str
    why: str
    time: float

    def __str__(self) -> str:
        return f"{self.which}: {self.why}" if self.why else self.which


class LatchedFaults:
    """The faults since the last reset, one of a kind: what came first says most."""

    def __init__(self) -> None:
        self._faults: list[Fault] = []

    def __bool__(self) -> bool:
        return bool(self._faults)

    @property
    def all(self) -> tuple[Fault, ...]:
        """What is latched, oldest first."""
        return tuple(self._faults)

    def latch(self, which: str, why: str, time: float) -> None:
        """Add a fault, unless one of its kind is there already."""
        if all(fault.which != which for fault in self._faults):
            self._faults.append(Fault(which, why, time))

    def clear(self) -> None:
        """Forget all of them: the explicit reset."""
        self._faults.clear()
