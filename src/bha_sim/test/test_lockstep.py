"""When the simulator may step: the wall clock is an argument, so no test waits."""

from typing import Any

import pytest

from bha_sim.lockstep import Pace, PaceSettings

PERIOD = 0.02


def pace(factor: float, now: float = 100.0, timeout: float = 5.0) -> Pace:
    return Pace(PaceSettings(real_time_factor=factor, lockstep_timeout=timeout), PERIOD, now)


class TestPaced:
    @pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
    def test_steps_at_the_factor(self, factor: float) -> None:
        """A thousand steps take their time to the microsecond, though each wait is rounded."""
        now, clock = 100.0, pace(factor)
        for _ in range(1000):
            clock.published(now)
            wait = clock.wait(now, answered=True)
            assert wait <= PERIOD / factor + 1e-9
            now += max(wait, 0.0)
            assert clock.wait(now, answered=True) <= 1e-9
        assert now - 100.0 == pytest.approx(1000 * PERIOD / factor, abs=1e-6)

    def test_does_not_wait_for_commands(self) -> None:
        clock = pace(1.0)
        clock.published(100.0)
        clock.answered()
        assert not clock.in_step
        assert clock.wait(100.0, answered=False) == clock.wait(100.0, answered=True) > 0.0

    def test_a_late_step_is_caught_up(self) -> None:
        """A hiccup below one period does not slow the simulation down."""
        clock = pace(1.0)
        clock.published(100.0)
        clock.published(100.035)  # the step was due at 100.02, and is 15 ms late
        assert clock.wait(100.035, answered=True) == pytest.approx(0.005)

    def test_a_long_halt_is_not_caught_up(self) -> None:
        """Else the robot would run at full speed after its computer was suspended."""
        clock, now, steps = pace(1.0), 100.0, 0
        clock.published(now)
        now += 60.0
        while clock.wait(now, answered=True) <= 0.0:
            clock.published(now)
            steps += 1
        assert steps <= 3

    def test_goes_on_at_its_pace_after_a_pause(self) -> None:
        clock = pace(1.0)
        clock.published(100.0)
        clock.resume(200.0)
        assert clock.wait(200.0, answered=True) == pytest.approx(PERIOD)
        assert not clock.in_step


class TestLockstep:
    def in_step(self, now: float = 100.0, timeout: float = 5.0) -> Pace:
        clock = pace(0.0, now, timeout)
        clock.published(now)
        clock.answered()
        assert clock.in_step
        return clock

    def test_goes_at_real_time_before_anybody_answers(self) -> None:
        """There may be no controller yet, and the robot's time goes on."""
        now, clock = 100.0, pace(0.0)
        for _ in range(50):
            assert not clock.in_step
            clock.published(now)
            now += max(clock.wait(now, answered=False), 0.0)
        assert now - 100.0 == pytest.approx(50 * PERIOD)

    def test_steps_at_once_when_answered(self) -> None:
        clock = self.in_step()
        for tick in range(100):
            now = 100.0 + 1e-4 * tick
            clock.published(now)
            assert clock.wait(now, answered=False) == pytest.approx(5.0)
            assert clock.wait(now, answered=True) == 0.0
        assert clock.timeouts == 0

    def test_waits_as_long_as_the_timeout_and_no_longer(self) -> None:
        clock = self.in_step(timeout=2.0)
        clock.published(100.0)
        assert clock.wait(101.5, answered=False) == pytest.approx(0.5)
        assert clock.in_step
        assert clock.wait(102.0, answered=False) <= 0.0
        assert not clock.in_step
        assert clock.timeouts == 1

    def test_goes_on_at_real_time_after_a_timeout(self) -> None:
        """A robot whose controller died comes to its safe state, and not at once."""
        clock, now = self.in_step(timeout=2.0), 102.0
        clock.wait(now, answered=False)
        for _ in range(50):
            clock.published(now)
            now += max(clock.wait(now, answered=False), 0.0)
        assert now - 102.0 == pytest.approx(50 * PERIOD, abs=2 * PERIOD)
        assert clock.timeouts == 1

    def test_is_in_step_again_with_the_next_answer(self) -> None:
        clock = self.in_step(timeout=2.0)
        clock.wait(102.0, answered=False)
        clock.published(102.0)
        clock.answered()
        assert clock.in_step
        assert clock.wait(102.0, answered=True) == 0.0
        clock.published(102.1)
        assert clock.wait(102.1, answered=False) == pytest.approx(2.0)

    def test_each_timeout_is_counted(self) -> None:
        clock, now = self.in_step(timeout=2.0), 100.0
        for count in range(1, 4):
            clock.published(now)
            clock.answered()
            now += 2.0
            clock.wait(now, answered=False)
            assert clock.timeouts == count

    def test_holds_from_the_first_state_after_a_pause(self) -> None:
        """Who ends a pause says that all are ready; the time of the pause is no time out."""
        clock = pace(0.0)
        clock.resume(500.0)
        assert clock.in_step
        clock.published(500.0)
        assert clock.wait(500.0, answered=False) == pytest.approx(5.0)
        assert clock.wait(500.0, answered=True) == 0.0
        clock.resume(900.0)
        assert clock.wait(900.0, answered=False) == pytest.approx(5.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"real_time_factor": -1.0},
        {"real_time_factor": float("nan")},
        {"real_time_factor": float("inf")},
        {"lockstep_timeout": 0.0},
    ],
)
def test_settings_out_of_range(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        PaceSettings(**wrong)
