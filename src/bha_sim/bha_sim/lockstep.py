"""When the simulator may take its next step: paced by a wall clock, or in lockstep."""

from __future__ import annotations

from dataclasses import dataclass

from bha_common.settings import check_settings, setting


@dataclass(frozen=True)
class PaceSettings:
    """How fast simulated time passes."""

    real_time_factor: float = setting(
        1.0, "Simulated over wall time; 0 is lockstep: each state waits for its command", low=0.0
    )
    lockstep_timeout: float = setting(
        5.0, "Wall time after which a lockstep wait for a command ends [s]", low=0.01
    )

    def __post_init__(self) -> None:
        check_settings(self)


class Pace:
    """Tells when the next step is due.

    In lockstep a step is due as soon as the command for the present state is there. When none
    comes in time, steps go at the pace of real time until a command fits again: a simulator
    whose controller died goes on, and comes to its safe state.

    Parameters
    ----------
    settings : Real-time factor and timeout.
    period : Control period [s].
    now : Wall time now [s].
    """

    def __init__(self, settings: PaceSettings, period: float, now: float) -> None:
        self._settings = settings
        self._lockstep = settings.real_time_factor == 0.0
        self._wall_period = period / (settings.real_time_factor or 1.0)
        self._due = now
        self._waiting_since: float | None = None
        self.in_step = False
        self.timeouts = 0

    def published(self, now: float) -> None:
        """Note that a state was published at wall time `now` [s] and its step is to come."""
        self._waiting_since = now
        self._due = max(self._due + self._wall_period, now - self._wall_period)

    def answered(self) -> None:
        """Note that the command for the present state has come."""
        self.in_step = self._lockstep

    def resume(self, now: float) -> None:
        """Begin anew after a pause, at wall time `now` [s].

        Who ends a pause says that all are ready: lockstep holds from the first state on.
        """
        self.in_step = self._lockstep
        self._due = now + self._wall_period
        self._waiting_since = now

    def wait(self, now: float, answered: bool) -> float:
        """Tell how long to wait for the next step [s]; 0 or less when it is due.

        Parameters
        ----------
        now : Wall time [s].
        answered : Whether the command for the present state has come.
        """
        if not self.in_step:
            return self._due - now
        if answered:
            return 0.0
        assert self._waiting_since is not None
        left = self._waiting_since + self._settings.lockstep_timeout - now
        if left <= 0.0:
            self.in_step = False
            self.timeouts += 1
            self._due = now
        return left
