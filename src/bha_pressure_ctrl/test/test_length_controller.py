"""Control of the lengths, on a plant whose every number is known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from bha_pressure_ctrl.bellows_dynamics import BellowsDynamics
from bha_pressure_ctrl.command_shaping import ShapingSettings
from bha_pressure_ctrl.equilibrium_model import Array, EquilibriumModel
from bha_pressure_ctrl.length_controller import LengthController, LengthControllerSettings

PERIOD = 0.02
MAX_PRESSURE = 1.3e5
MIDDLE = np.full(9, 0.2)
# Each bellows pushes its neighbour a little.
SLOPE = 5e5 * (np.eye(9) + 0.15 * np.roll(np.eye(9), 1, axis=0))
MODEL = replace(
    EquilibriumModel.affine(MIDDLE, np.full(9, 6e4), SLOPE),
    dynamics=BellowsDynamics(response_lag=0.0),
)
COMMAND = 0.2 + 0.02 * np.sin(np.arange(9.0))


class Plant:
    """Bellows that follow the inverse of the model with a lag, some of it not as the model says."""

    def __init__(self, lag: float = 0.4, stiffness: float = 1.0, offset: float = 0.0) -> None:
        self._share = 1.0 - np.exp(-PERIOD / lag)
        self._compliance = np.linalg.inv(stiffness * SLOPE)
        self._offset = offset
        self.lengths = MIDDLE + offset

    def step(self, pressures: Array) -> None:
        rest = MIDDLE + self._compliance @ (pressures - 6e4) + self._offset
        self.lengths = self.lengths + self._share * (rest - self.lengths)


AT_ONCE = ShapingSettings(0.0, response_lag=0.0)
"""Expects every command to be followed at once."""

AS_THE_PLANT = ShapingSettings(0.0, response_lag=0.4)
"""Expects a plant with a lag of 0.4 s."""


def controller(shaping: ShapingSettings = AS_THE_PLANT, **gains: float) -> LengthController:
    settings = LengthControllerSettings(**gains)
    return LengthController(MODEL, settings, shaping, max_pressure=MAX_PRESSURE, period=PERIOD)


def run(control: LengthController, plant: Plant, command: Array, seconds: float) -> Array:
    """Control for a while; return all lengths, shape (ticks, 9)."""
    lengths = []
    for _ in range(round(seconds / PERIOD)):
        plant.step(control.update(command, plant.lengths))
        lengths.append(plant.lengths)
    return np.array(lengths)


def test_with_a_perfect_model_the_feed_forward_is_the_answer() -> None:
    pressures = controller().update(COMMAND, COMMAND)
    np.testing.assert_allclose(pressures, MODEL.pressures(COMMAND))


def test_is_the_sum_of_its_three_terms() -> None:
    control = controller(AT_ONCE, proportional_gain=2e5, integral_gain=1e6, adaptation_time=0.0)
    lengths = COMMAND - 1e-3
    expected = MODEL.pressures(COMMAND) + 2e5 * 1e-3
    for tick in range(1, 6):
        pressures = control.update(COMMAND, lengths)
        np.testing.assert_allclose(pressures, expected + tick * 1e6 * PERIOD * 1e-3)


def test_a_new_command_finds_no_error() -> None:
    """A robot that follows as expected is driven by the feed-forward alone."""
    feedforward = controller(proportional_gain=0, integral_gain=0)
    feedback = controller()
    lengths = [
        np.vstack([run(control, plant, c, 2.0) for c in (MIDDLE, COMMAND, 0.4 - COMMAND, MIDDLE)])
        for control, plant in ((feedforward, Plant()), (feedback, Plant()))
    ]
    assert np.ptp(lengths[0], axis=0).max() > 0.03
    np.testing.assert_allclose(lengths[1], lengths[0], atol=1e-3)


@pytest.mark.parametrize("stiffness", [0.9, 1.0, 1.2])
def test_the_integral_does_not_fight_the_feed_forward(stiffness: float) -> None:
    """What it winds up against a feed-forward that is at work, it must overshoot to lose."""
    overshoots = []
    for shaping in (AS_THE_PLANT, AT_ONCE):
        control, plant = controller(shaping), Plant(stiffness=stiffness)
        run(control, plant, MIDDLE, 20.0)
        lengths = run(control, plant, COMMAND, 10.0)
        overshoots.append((np.sign(COMMAND - MIDDLE) * (lengths - COMMAND)).max())
    assert overshoots[0] < 0.5 * overshoots[1]
    assert overshoots[1] > 1e-3


@pytest.mark.parametrize("lag", [0.1, 0.4, 1.0])
@pytest.mark.parametrize("stiffness", [0.8, 1.0, 1.3])
@pytest.mark.parametrize("offset", [-0.01, 0.0, 0.01])
def test_comes_to_the_command_whatever_the_model_does_not_know(
    lag: float, stiffness: float, offset: float
) -> None:
    """Stiffness 20 to 30 % off and rest lengths 1 cm off: the integral finds the rest."""
    plant = Plant(lag, stiffness, offset)
    lengths = run(controller(), plant, COMMAND, 20.0)
    assert np.abs(lengths[-1] - COMMAND).max() < 1e-5
    assert np.abs(lengths - COMMAND).max() < 0.05  # without wild swings on the way


def test_without_the_integral_an_error_stays() -> None:
    """The test above can fail."""
    lengths = run(controller(integral_gain=0.0), Plant(offset=0.01), COMMAND, 20.0)
    assert np.abs(lengths[-1] - COMMAND).max() > 3e-3


def test_what_the_integral_has_found_is_kept_for_the_next_command() -> None:
    """Creep and drift do not go away with a new command."""
    plant, control = Plant(offset=0.01), controller()
    run(control, plant, COMMAND, 20.0)
    following = run(control, plant, COMMAND + 0.005, 5.0)
    fresh = run(controller(), Plant(offset=0.01), COMMAND + 0.005, 5.0)
    assert (
        np.abs(following[50] - COMMAND - 0.005).max()
        < 0.5 * np.abs(fresh[50] - COMMAND - 0.005).max()
    )


def test_less_of_the_integral_is_carried_the_further_the_command_goes() -> None:
    found = np.array([_carried(distance) for distance in (0.0, 0.03, 0.09, 0.5)])
    np.testing.assert_allclose(found, np.exp([0.0, -1 / 3, -1.0, -0.5 / 0.09]), atol=1e-6)
    assert _carried(0.5, carry_distance=0.0) == pytest.approx(1.0)


def _carried(distance: float, **gains: float) -> float:
    """Share of the integral, told by the pressures at a command so far away, at no error there."""
    pressures = []
    for error in (0.002, 0.0):
        control = controller(AT_ONCE, adaptation_time=0.0, **gains)
        control.update(COMMAND, COMMAND - error)
        command = COMMAND + distance / 3.0
        pressures.append(control.update(command, command))
    # What one period adds to the integral.
    return float((pressures[0] - pressures[1]).mean() / (8e5 * PERIOD * 0.002))


def test_reset_forgets_the_integral() -> None:
    control = controller(AT_ONCE)
    first = control.update(COMMAND, COMMAND - 0.01)
    assert (control.update(COMMAND, COMMAND - 0.01) > first).all()
    control.reset()
    np.testing.assert_array_equal(control.update(COMMAND, COMMAND - 0.01), first)


@settings(max_examples=60, deadline=None)
@given(
    hnp.arrays(np.float64, (6, 2, 9), elements=st.floats(-1e3, 1e3)),
    st.floats(0.0, 2e6),
    st.floats(0.0, 5e6),
)
def test_pressures_are_always_in_range(values: Array, proportional: float, integral: float) -> None:
    control = controller(proportional_gain=proportional, integral_gain=integral)
    for command, lengths in values:
        pressures = control.update(command, lengths)
        assert pressures.shape == (9,)
        assert (pressures >= 0.0).all()
        assert (pressures <= MAX_PRESSURE).all()


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("seconds", [5.0, 300.0])
def test_recovers_at_once_from_a_command_out_of_reach(side: float, seconds: float) -> None:
    """However long it was at the end of its range: as fast as one that has not been there."""
    plant, control = Plant(), controller()
    run(control, plant, MIDDLE + side * 0.3, seconds)
    ends = control.update(MIDDLE + side * 0.3, plant.lengths)
    np.testing.assert_array_equal(ends, MAX_PRESSURE if side > 0 else 0.0)

    fresh_plant = Plant()
    fresh_plant.lengths = plant.lengths
    fresh = run(controller(), fresh_plant, COMMAND, 15.0)
    lengths = run(control, plant, COMMAND, 15.0)
    overshoot = -side * (lengths - COMMAND)
    # What the linear controller itself overshoots, and 2 mm for what it had integrated before.
    assert overshoot.max() <= (-side * (fresh - COMMAND)).max() + 2e-3
    late = np.abs(lengths - COMMAND).max(axis=1) > 1e-3
    late_fresh = np.abs(fresh - COMMAND).max(axis=1) > 1e-3
    assert late.nonzero()[0].max() <= late_fresh.nonzero()[0].max() + round(2.5 / PERIOD)


def test_one_bellows_at_its_end_leaves_the_others_in_control() -> None:
    command = COMMAND.copy()
    command[4] = 0.6
    plant = Plant(offset=0.005)
    lengths = run(controller(), plant, command, 30.0)
    others = np.arange(9) != 4
    assert np.abs(lengths[-1] - command)[others].max() < 1e-4


class TestAdaptation:
    """The model takes over what the integral has found."""

    def test_it_learns_how_far_the_robot_has_aged(self) -> None:
        """Rest lengths 5 mm longer: the slope times that is the answer, and then no more."""
        control, plant = controller(adaptation_time=20.0), Plant(offset=0.005)
        rng = np.random.default_rng(0)
        for _ in range(40):
            run(control, plant, 0.2 + 0.02 * rng.uniform(-1.0, 1.0, 9), 8.0)
        aged = np.full(9, 0.205) + 0.01 * rng.uniform(-1.0, 1.0, 9)
        wanted = MODEL.pressures(aged - 0.005)
        np.testing.assert_allclose(control.model.pressures(aged), wanted, atol=50.0)
        assert (control.model.lowest_slopes() == MODEL.lowest_slopes()).all()

    def test_it_is_kept_through_a_reset_and_the_integral_is_not(self) -> None:
        control, plant = controller(adaptation_time=5.0), Plant(offset=0.005)
        run(control, plant, COMMAND, 60.0)
        learned = control.model.pressures(COMMAND)
        control.reset()
        np.testing.assert_allclose(control.update(COMMAND, COMMAND), learned)

    def test_pressures_do_not_jump_with_it(self) -> None:
        pressures = []
        for time in (0.0, 1.0):
            control, plant = controller(adaptation_time=time), Plant(offset=0.01)
            applied = []
            for _ in range(500):
                applied.append(control.update(COMMAND, plant.lengths))
                plant.step(applied[-1])
            pressures.append(np.array(applied))
        np.testing.assert_allclose(pressures[0], pressures[1], rtol=1e-9)

    def test_it_does_not_learn_far_from_the_command(self) -> None:
        """A bellows that cannot reach its command tells nothing about the model."""
        control, plant = controller(adaptation_time=1.0), Plant()
        run(control, plant, np.full(9, 0.39), 60.0)
        assert control.model is MODEL

    def test_beyond_the_range_it_answers_as_the_model_that_would_be_saved(self) -> None:
        """What was learned does not lift a pressure off the end that the model has it at."""
        control = controller(adaptation_time=5.0, proportional_gain=0.0, integral_gain=8e5)
        run(control, Plant(offset=-0.01), COMMAND, 60.0)
        control.reset()
        vented = np.full(9, 0.08)
        saved = control.model.pressures(vented)
        assert (saved < 1e3).all()
        np.testing.assert_allclose(control.update(vented, vented), saved, atol=1e-6)

    def test_it_can_be_switched_off(self) -> None:
        control = controller(adaptation_time=0.0)
        run(control, Plant(offset=0.01), COMMAND, 20.0)
        assert control.model is MODEL


def test_does_not_change_what_it_is_given() -> None:
    command, lengths = COMMAND.copy(), MIDDLE.copy()
    controller().update(command, lengths)
    np.testing.assert_array_equal(command, COMMAND)
    np.testing.assert_array_equal(lengths, MIDDLE)


@pytest.mark.parametrize(
    "wrong",
    [{"proportional_gain": -1.0}, {"proportional_gain": 3e6}, {"integral_gain": float("nan")}],
)
def test_gains_out_of_range(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        LengthControllerSettings(**wrong)


NO_FEEDBACK = {"proportional_gain": 0.0, "integral_gain": 0.0}


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_command_is_approached_from_where_it_comes_from(side: float) -> None:
    """Pressures and expected lengths alike; where nothing was to go, nothing falls short."""
    way = side * np.linspace(0.0, 0.03, 9)
    control = controller(ShapingSettings(0.2, response_lag=0.0, shortfall=1e-3), **NO_FEEDBACK)
    at_once = Plant(lag=1e-6)
    run(control, at_once, MIDDLE, 1.0)
    lengths = run(control, at_once, MIDDLE + way, 8.0)
    short = side * (MIDDLE + way - lengths)
    assert short[15, 0] == pytest.approx(0.0, abs=1e-9)
    assert 0.6e-3 < short[15, -1] < 0.9e-3
    assert (short[15:] > -1e-5).all()
    np.testing.assert_allclose(short[-1], 0.0, atol=1e-5)


def test_commands_that_move_slowly_are_hardly_fallen_short_of() -> None:
    """And those that go to and fro by no more than the shortfall."""
    control = controller(ShapingSettings(0.0, response_lag=0.0, shortfall=1e-3), **NO_FEEDBACK)
    at_once = Plant(lag=1e-6)
    run(control, at_once, MIDDLE, 1.0)
    for tick in range(1, 200):
        command = MIDDLE + 5e-3 * PERIOD * tick
        lengths = run(control, at_once, command, PERIOD)
    assert 0.1e-3 < (command - lengths[-1]).max() < 0.6e-3
    for sign in (-1.0, 1.0) * 10:
        command = MIDDLE + sign * 0.02
        lengths = run(control, at_once, command, PERIOD)
    assert np.abs(command - lengths[-1]).max() <= 1e-3 + 1e-9
