"""Control, identification and the safe state, one control period after the other."""

from typing import Any

import numpy as np
import pytest
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, rule

from bha_common.command_gate import SafetySettings
from bha_pressure_ctrl.equilibrium_model import Array, EquilibriumModel, EquilibriumModelError
from bha_pressure_ctrl.identification import IdentificationSettings
from bha_pressure_ctrl.pressure_control import PressureControl, PressureControlSettings

PERIOD = 0.02
STIFFNESS = 5e5
MODEL = EquilibriumModel.affine(np.full(9, 0.2), np.full(9, 6e4), STIFFNESS * np.eye(9))
LENGTHS = np.full(9, 0.2)
COMMAND = np.full(9, 0.21)
QUICK = IdentificationSettings(samples=20, rest_window=0.1, rest_speed=1.0, pressure_rate=1e7)


class Loop:
    """Calls the controller with lengths, tick by tick, and keeps the time."""

    def __init__(self, model: EquilibriumModel | None = None, **safety: Any) -> None:
        self.settings = PressureControlSettings(
            identification=QUICK, safety=SafetySettings(**{"command_timeout": 2.0, **safety})
        )
        self.control = PressureControl(self.settings, model)
        self.time = 1.0
        self.pressures = np.zeros(9)

    def step(self, seconds: float = PERIOD, lengths: Array = LENGTHS) -> Array:
        for _ in range(round(seconds / PERIOD)):
            self.time += PERIOD
            self.pressures = self.control.update(self.time, lengths).copy()
        return self.pressures

    def command(self, lengths: Array = COMMAND) -> None:
        self.control.command(self.time, lengths)

    def press(self) -> None:
        """Come under pressure."""
        self.command()
        assert (self.step() > 5e4).all()
        assert self.control.mode == PressureControl.CONTROL

    def vents(self) -> None:
        """Check that the pressures fall at the rate of the settings, down to zero."""
        rate = self.settings.safety.vent_rate
        while self.pressures.any():
            before = self.pressures
            np.testing.assert_allclose(self.step(), np.maximum(before - rate * PERIOD, 0.0))


def fill(loop: Loop, scale: float = 1.0) -> None:
    """Let an identification run to its end on a robot that follows at once."""
    identification = loop.control.identification
    assert identification is not None
    for _ in range(20_000):
        if identification.done:
            return
        loop.step(lengths=0.15 + scale * loop.pressures / STIFFNESS)
    raise AssertionError("identification did not end")


class TestWithoutModel:
    def test_it_says_so_and_applies_nothing(self) -> None:
        loop = Loop()
        loop.command()
        np.testing.assert_array_equal(loop.step(1.0), np.zeros(9))
        assert loop.control.mode == PressureControl.NO_MODEL
        assert loop.control.model is None

    def test_it_vents_what_there_is(self) -> None:
        loop = Loop(MODEL)
        loop.press()
        loop.control.use(None)
        loop.command()
        loop.vents()
        assert loop.control.mode == PressureControl.NO_MODEL

    def test_it_begins_once_there_is_a_model(self) -> None:
        loop = Loop()
        loop.step(0.1)
        loop.control.use(MODEL)
        loop.press()


class TestSilence:
    def test_without_a_first_command(self) -> None:
        loop = Loop(MODEL)
        np.testing.assert_array_equal(loop.step(1.0), np.zeros(9))
        assert loop.control.mode == PressureControl.SILENT

    def test_a_command_holds_until_the_timeout(self) -> None:
        loop = Loop(MODEL)
        loop.command()
        loop.step(2.0)
        assert loop.control.mode == PressureControl.CONTROL
        loop.step()
        assert loop.control.mode == PressureControl.SILENT
        loop.vents()

    def test_every_command_begins_the_time_anew(self) -> None:
        loop = Loop(MODEL)
        for _ in range(20):
            loop.command()
            loop.step(1.9)
            assert loop.control.mode == PressureControl.CONTROL

    def test_recovers_with_the_next_command(self) -> None:
        loop = Loop(MODEL)
        loop.press()
        loop.step(9.0)
        loop.press()

    def test_a_slow_leak_of_the_integral_does_not_survive(self) -> None:
        """What it had integrated belongs to a robot under pressure, not to a vented one."""
        loop = Loop(MODEL)
        loop.press()
        first = loop.pressures
        for _ in range(5):
            loop.command()
            loop.step(1.0)
        assert (loop.pressures > first).all()
        loop.step(9.0)
        loop.command()
        np.testing.assert_array_equal(loop.step(), first)

    def test_hold(self) -> None:
        loop = Loop(MODEL, safe_state="hold")
        loop.press()
        loop.step(2.0)
        held = loop.pressures
        np.testing.assert_array_equal(loop.step(9.0), held)
        assert loop.control.mode == PressureControl.SILENT

    @pytest.mark.parametrize("safe_state", ["vent", "hold"])
    def test_a_robot_that_was_started_anew(self, safe_state: str) -> None:
        """It is vented, and neither the command nor the pressures of before come to it."""
        loop = Loop(MODEL, safe_state=safe_state)
        loop.press()
        loop.control.begin_anew()
        loop.step()
        assert loop.control.mode == PressureControl.SILENT
        assert not loop.pressures.any()


class TestStop:
    def test_vents_whatever_is_commanded(self) -> None:
        loop = Loop(MODEL)
        loop.press()
        loop.control.stop(True)
        assert loop.control.stopped
        while loop.pressures.any():
            before = loop.pressures
            loop.command()
            assert (loop.step() <= before).all()
            assert loop.control.mode == PressureControl.STOPPED

    def test_nothing_comes_back_by_itself(self) -> None:
        """Neither the command before the stop nor one that came while it lasted."""
        loop = Loop(MODEL)
        loop.press()
        loop.control.stop(True)
        loop.command()
        loop.step(0.5)
        loop.control.stop(False)
        assert not loop.control.stopped
        before = loop.pressures
        assert (loop.step() <= before).all()
        assert loop.control.mode == PressureControl.SILENT
        loop.vents()
        loop.press()

    def test_a_stop_that_is_reset_within_one_period_drops_the_command_too(self) -> None:
        loop = Loop(MODEL)
        loop.press()
        loop.control.stop(True)
        loop.control.stop(False)
        loop.step()
        assert loop.control.mode == PressureControl.SILENT

    def test_ends_identification(self) -> None:
        loop = Loop(MODEL)
        loop.control.identify()
        loop.step(0.2)
        loop.control.stop(True)
        assert loop.control.identification is None
        loop.vents()
        loop.control.stop(False)
        loop.step()
        assert loop.control.mode == PressureControl.SILENT

    def test_refuses_identification(self) -> None:
        loop = Loop(MODEL)
        loop.control.stop(True)
        with pytest.raises(RuntimeError, match="emergency stop is active"):
            loop.control.identify()
        loop.vents()
        loop.control.stop(False)
        loop.control.identify()


class TestIdentify:
    def test_fits_a_model_and_uses_it(self) -> None:
        loop = Loop()
        running = loop.control.identify()
        loop.step()
        assert loop.control.mode == PressureControl.IDENTIFY
        fill(loop)
        model = loop.control.finish_identification()
        assert loop.control.model is model
        assert loop.control.identification is None
        assert model.samples == running.requested == 20
        held = model.pressures(np.full(9, 0.2))
        np.testing.assert_allclose(held, 0.05 * STIFFNESS, atol=0.02 * model.max_pressure)
        loop.step()
        assert loop.control.mode == PressureControl.SILENT

    def test_begins_where_the_pressures_are(self) -> None:
        slow = IdentificationSettings(pressure_rate=1e4)
        control = PressureControl(PressureControlSettings(identification=slow), MODEL)
        control.command(1.0, COMMAND)
        before = control.update(1.0, LENGTHS).copy()
        control.identify()
        after = control.update(1.02, LENGTHS)
        assert np.abs(after - before).max() <= 1e4 * PERIOD * (1 + 1e-9)

    def test_needs_no_commands(self) -> None:
        """It lasts longer than any timeout."""
        loop = Loop(MODEL)
        loop.control.identify()
        fill(loop, scale=0.0)
        assert loop.control.mode == PressureControl.IDENTIFY

    def test_commands_do_not_disturb_it(self) -> None:
        loops = Loop(MODEL), Loop(MODEL)
        for loop in loops:
            loop.control.identify()
        for _ in range(200):
            loops[1].command()
            np.testing.assert_array_equal(loops[0].step(), loops[1].step())

    def test_the_number_of_samples_can_be_chosen(self) -> None:
        assert Loop().control.identify(33).requested == 33

    @pytest.mark.parametrize("samples", [0, -1])
    def test_no_samples_are_refused(self, samples: int) -> None:
        loop = Loop(MODEL)
        with pytest.raises(ValueError, match=f"at least 1, got {samples}"):
            loop.control.identify(samples)
        assert loop.control.identification is None

    def test_only_one_at_a_time(self) -> None:
        loop = Loop()
        loop.control.identify()
        with pytest.raises(RuntimeError, match="running already"):
            loop.control.identify()

    def test_the_seed_draws_the_postures(self) -> None:
        def path(seed: int) -> Array:
            control = PressureControl(PressureControlSettings(seed=seed, identification=QUICK))
            control.identify()
            return np.array([control.update(1.0 + k * PERIOD, LENGTHS).copy() for k in range(99)])

        np.testing.assert_array_equal(path(1), path(1))
        assert not np.array_equal(path(1), path(2))

    @pytest.mark.parametrize("model", [None, MODEL])
    def test_a_fit_that_fails_leaves_the_model(self, model: EquilibriumModel | None) -> None:
        """A robot without air: the pressures change, the lengths do not."""
        loop = Loop(model)
        loop.control.identify()
        fill(loop, scale=0.0)
        with pytest.raises(EquilibriumModelError, match="hardly changed"):
            loop.control.finish_identification()
        assert loop.control.model is model
        assert loop.control.identification is None
        loop.control.identify()

    def test_one_that_is_ended_too_early_leaves_the_model(self) -> None:
        loop = Loop(MODEL)
        loop.control.identify()
        loop.step(1.0)
        with pytest.raises(EquilibriumModelError, match="at least 20 are needed"):
            loop.control.finish_identification()
        assert loop.control.model is MODEL

    def test_abandoned(self) -> None:
        loop = Loop(MODEL)
        loop.control.identify()
        loop.step(1.0)
        loop.control.abandon_identification()
        assert loop.control.model is MODEL
        loop.vents()
        loop.press()

    def test_control_begins_afresh_where_identification_leaves_the_robot(self) -> None:
        """What the integral holds and was expected is of another posture by then."""
        applied = []
        for away in (0.15, 0.25):
            loop = Loop(MODEL)
            loop.press()
            loop.step(1.0, lengths=np.full(9, away))  # winds up, to the one side or the other
            loop.control.identify()
            loop.step(1.0)
            loop.control.abandon_identification()
            loop.command()
            applied.append(loop.step())
        np.testing.assert_array_equal(*applied)

    def test_none_to_finish(self) -> None:
        with pytest.raises(RuntimeError, match="no identification"):
            Loop(MODEL).control.finish_identification()


@pytest.mark.parametrize("wrong", [{"control_period": 0.0}, {"seed": -1}])
def test_settings_out_of_range(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        PressureControlSettings(**wrong)


class AnyOrder(RuleBasedStateMachine):
    """Whatever is asked in whatever order, pressures are in range and never rise while stopped."""

    def __init__(self) -> None:
        super().__init__()
        self.loop = Loop(MODEL, max_pressure=1e5)

    @rule(length=st.floats(-10.0, 10.0))
    def command(self, length: float) -> None:
        self.loop.command(np.full(9, length))

    @rule(stopped=st.booleans())
    def stop(self, stopped: bool) -> None:
        self.loop.control.stop(stopped)

    @rule()
    def begin_anew(self) -> None:
        self.loop.control.begin_anew()

    @rule(known=st.booleans())
    def use(self, known: bool) -> None:
        self.loop.control.use(MODEL if known else None)

    @rule()
    def identify(self) -> None:
        control = self.loop.control
        if control.stopped or control.identification is not None:
            with pytest.raises(RuntimeError):
                control.identify()
        else:
            control.identify()

    @rule()
    def finish(self) -> None:
        control = self.loop.control
        model, running = control.model, control.identification
        try:
            fitted = control.finish_identification()
        except (RuntimeError, EquilibriumModelError):
            assert control.model is model
        else:  # lengths that changed once were there for every posture
            assert running is not None
            assert control.model is fitted
        assert control.identification is None

    @rule(length=st.floats(0.0, 1.0), seconds=st.sampled_from([PERIOD, 0.2, 3.0]))
    def advance(self, length: float, seconds: float) -> None:
        before = self.loop.pressures
        after = self.loop.step(seconds, np.full(9, length))
        if self.loop.control.stopped:
            assert self.loop.control.mode == PressureControl.STOPPED
            assert (after <= before).all()

    @invariant()
    def in_range(self) -> None:
        assert ((self.loop.pressures >= 0.0) & (self.loop.pressures <= 1e5)).all()


TestAnyOrder = AnyOrder.TestCase
TestAnyOrder.settings = hypothesis_settings(max_examples=30, stateful_step_count=20, deadline=None)
