"""What a learner knows of its body, in the units of the robot: units, corrections, snapshots."""

import dataclasses

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.body_model import BodyModel
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.planar_arm import PlanarArm
from bha_goal_babbling.saved_state import SavedState

ARM = PlanarArm(5)
HOME, TIP = ARM.home(), ARM.forward(ARM.home())
CONFIG = GoalBabblerConfig(
    forward_model="polynomial",
    action_scale=1.5,
    outcome_scale=0.5,
    outcome_noise=0.003,
    offset_spread=0.05,
    offset_samples=2000.0,
)
NO_OFFSETS = dataclasses.replace(CONFIG, offset_spread=0.0)


def body(config: GoalBabblerConfig = CONFIG, joints: int = 5) -> BodyModel:
    home = PlanarArm(joints).home()
    limits = np.full(joints, 3.0)
    return BodyModel(config, home, PlanarArm(joints).forward(home), -limits, limits)


def examples(samples: int, seed: int) -> FloatArray:
    """Return angles around home, shape (samples, 5)."""
    return HOME + np.random.default_rng(seed).uniform(-0.4, 0.4, (samples, 5))


def taught(config: GoalBabblerConfig, samples: int = 800) -> BodyModel:
    """Return a model that was shown single postures, without offsets."""
    model = body(config)
    for angles in examples(samples, 0):
        model.learn(angles, ARM.forward(angles))
    return model


def test_knows_nothing_at_first() -> None:
    """Answers stay as they are, readings too."""
    model = body()
    np.testing.assert_allclose(model.predict(HOME + 1.0), TIP, rtol=1e-15)
    answer = model.refine(HOME + 0.3, TIP + 0.1, explores=True)
    np.testing.assert_allclose(answer, HOME + 0.3, rtol=1e-14)
    np.testing.assert_array_equal(model.offsets, np.zeros(5))


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_ends_that_were_found_hold_and_the_others_make_up_for_them(side: float) -> None:
    model = taught(NO_OFFSETS)
    angles = HOME + np.array([0.2, 0.2, -0.1, 0.1, 0.0])
    goal = ARM.forward(angles)
    low, high = np.full(5, -np.inf), np.full(5, np.inf)
    (high if side > 0 else low)[1] = angles[1] - 0.1 * side
    answer = model.refine(angles, goal, low, high)
    assert side * answer[1] <= side * (angles[1] - 0.1 * side) + 1e-12
    assert np.linalg.norm(ARM.forward(answer) - goal) < 0.005
    cut = np.clip(angles, low, high)
    assert np.linalg.norm(ARM.forward(cut) - goal) > 0.03


def test_learned_ends_give_way_to_those_that_were_found() -> None:
    """Even where they contradict each other."""
    model = body()
    for side in (-1.0, 1.0):
        beyond = np.full(5, 4.0 * side)
        low, high = (beyond, np.full(5, np.inf)) if side > 0 else (np.full(5, -np.inf), beyond)
        np.testing.assert_allclose(model.refine(HOME, TIP, low, high), beyond)


def test_refines_to_the_goal() -> None:
    """What an inverse model misses by centimetres is met to a millimetre or two."""
    model, rng = taught(NO_OFFSETS), np.random.default_rng(1)
    before, after = [], []
    for angles in examples(40, 2):
        goal = ARM.forward(angles)
        said = angles + 0.05 * rng.standard_normal(5)
        before.append(np.linalg.norm(ARM.forward(said) - goal))
        answer = model.refine(said, goal)
        after.append(np.linalg.norm(ARM.forward(answer) - goal))
        np.testing.assert_allclose(model.predict(answer), goal, atol=1e-3)
    assert np.mean(before) > 0.02
    assert np.mean(after) < 0.002


def test_moves_an_answer_by_its_reach_at_most() -> None:
    """0.6 of the scale of actions."""
    model = taught(NO_OFFSETS)
    away = model.refine(HOME, TIP + np.array([-0.8, 0.8])) - HOME
    assert np.linalg.norm(away) == pytest.approx(0.6 * CONFIG.action_scale)


@pytest.mark.parametrize(("action_unit", "outcome_unit"), [(1024.0, 1.0), (1.0, 0.125), (0.25, 8)])
def test_units_do_not_matter_when_the_scales_follow(
    action_unit: float, outcome_unit: float
) -> None:
    """To the last bit, as powers of two round nothing."""
    other = BodyModel(
        dataclasses.replace(
            CONFIG,
            action_scale=CONFIG.action_scale * action_unit,
            offset_spread=CONFIG.offset_spread * action_unit,
            outcome_scale=CONFIG.outcome_scale * outcome_unit,
            outcome_noise=CONFIG.outcome_noise * outcome_unit,
        ),
        HOME * action_unit,
        TIP * outcome_unit,
        np.full(5, -3.0 * action_unit),
        np.full(5, 3.0 * action_unit),
    )
    model = body()
    for t, angles in enumerate(examples(200, 3)):
        tip, asked = ARM.forward(angles - 0.04), HOME + 1.0
        command = None if t % 50 == 49 else asked
        action = model.learn(angles, tip, command)
        same = other.learn(
            angles * action_unit,
            tip * outcome_unit,
            None if command is None else command * action_unit,
        )
        np.testing.assert_array_equal(action * action_unit, same)
    np.testing.assert_array_equal(model.offsets * action_unit, other.offsets)
    assert np.abs(model.offsets).max() > 0.0
    for angles in examples(10, 4):
        tip = ARM.forward(angles)
        np.testing.assert_array_equal(
            model.predict(angles) * outcome_unit, other.predict(angles * action_unit)
        )
        np.testing.assert_array_equal(
            model.refine(angles + 0.1, tip) * action_unit,
            other.refine((angles + 0.1) * action_unit, tip * outcome_unit),
        )


def test_readings_are_corrected() -> None:
    """Sensors that slip are found out; what comes back is where the robot really was.

    Actions are scaled by about their range, as they should be: with a larger scale the arm bends
    more than the forward model's prior expects, and offsets are taken for what it misses.
    """
    config = dataclasses.replace(CONFIG, action_scale=1.0)
    model, slipped = taught(config), np.array([0.06, -0.04, 0.05, -0.06, 0.03])
    misses = []
    for angles in examples(300, 5):
        action = model.learn(angles + slipped, ARM.forward(angles))
        np.testing.assert_allclose(action, angles + slipped - model.offsets, rtol=1e-14)
        misses.append(np.abs(action - angles).max())
    assert misses[0] > 0.03
    assert np.mean(misses[-50:]) < 0.015


def test_ends_are_those_of_actions_not_of_readings() -> None:
    """A joint that ends at 0.1 rad beyond home: answers keep to it, and others make up for it."""
    model, end = body(NO_OFFSETS), HOME[0] + 0.1
    for command in examples(600, 6) + np.array([0.3, 0.0, 0.0, 0.0, 0.0]):
        angles = command.copy()
        angles[0] = min(angles[0], end)
        for _ in range(6):
            model.learn(angles, ARM.forward(angles), command)
    goal = ARM.forward(HOME + np.array([0.1, 0.2, 0.0, 0.0, 0.0]))
    answer = model.refine(HOME + np.array([0.3, 0.0, 0.0, 0.0, 0.0]), goal)
    assert answer[0] == pytest.approx(end, abs=0.02)
    assert np.linalg.norm(ARM.forward(answer) - goal) < 0.005


def test_a_robot_in_use_tries_beyond_ends_that_leave_a_goal_out() -> None:
    """By as much as they do, and by 0.06 of the scale of actions at most; exploration does not."""
    model = body(NO_OFFSETS)
    for command in HOME + 0.4 * np.clip(5.0 * (examples(600, 6) - HOME), -1.0, 1.0):
        angles = np.clip(command, HOME - 0.15, HOME + 0.15)
        for _ in range(6):
            model.learn(angles, ARM.forward(angles), command)

    def beyond(bend: float, *, explores: bool) -> float:
        angles = HOME + bend * np.array([1.0, 1.0, -1.0, -1.0, -1.0])
        answer = model.refine(angles, ARM.forward(angles), explores=explores)
        return float(np.abs(answer - HOME).max())

    near, out, far = (
        beyond(bend, explores=False) - beyond(bend, explores=True) for bend in (0.1, 0.2, 0.4)
    )
    assert abs(near) < 0.01 < out < 0.06
    assert far == pytest.approx(0.09)


def test_sensors_that_slipped_are_no_ends() -> None:
    """Commands are readings too: a robot whose readings are as asked for is stuck nowhere."""
    model = taught(CONFIG)
    for angles in examples(100, 10):
        for _ in range(6):
            model.learn(angles + 0.1, ARM.forward(angles), angles + 0.1)
    assert model.offsets.max() > 0.06
    state = model.state().arrays
    np.testing.assert_array_equal(state["range_low"][:, -1], -2.0)
    np.testing.assert_array_equal(state["range_high"][:, -1], 2.0)


def test_after_a_pause_the_robot_is_at_rest() -> None:
    """What it was about is forgotten: it neither moved just now, nor is a command still on."""
    model, twin = body(), body()
    far = np.tile(HOME + 1.0, (3, 1))
    for command in far:
        model.learn(HOME, TIP, command)
    model.pause()
    for command in far:
        before = model.state().arrays
        model.learn(HOME + 0.1, TIP, command)
        np.testing.assert_array_equal(model.state().arrays["range_high"], before["range_high"])
        np.testing.assert_array_equal(model.state().arrays["forward_parameters"][-10:], 0.0)
        model.pause()
    for angles in examples(3, 9):
        twin.learn(angles, ARM.forward(angles), HOME + 1.0)
    assert np.abs(twin.state().arrays["forward_parameters"][-10:]).max() > 0.0


def test_without_a_command_nothing_is_said_of_ends_and_lags() -> None:
    """A robot that went its own way may have been anywhere between two examples."""
    model, twin = taught(NO_OFFSETS, 50), taught(NO_OFFSETS, 50)
    for angles in examples(20, 7):
        model.learn(HOME, TIP)
        model.learn(angles, ARM.forward(angles))
        twin.learn(HOME, TIP)
        twin.learn(HOME + 0.5, TIP, HOME + 3.0)  # gets stuck once, and moves
        twin.learn(angles, ARM.forward(angles))
    low, high = (model.state().arrays[f"range_{end}"][:, -1] for end in ("low", "high"))
    np.testing.assert_array_equal([low, high], [[-2.0] * 5, [2.0] * 5])
    own, other = model.state().arrays, twin.state().arrays
    np.testing.assert_array_equal(own["range_high"], other["range_high"])
    lags = slice(-10, None)
    np.testing.assert_array_equal(own["forward_parameters"][lags], 0.0)
    assert np.abs(other["forward_parameters"][lags]).max() > 0.0


@pytest.mark.parametrize("samples", [0, 1, 2, 60])
def test_continues_bit_for_bit(samples: int) -> None:
    model, twin = body(), body()
    data = examples(samples + 40, 8)
    for angles in data[:samples]:
        model.learn(angles + 0.05, ARM.forward(angles), angles + 0.4)
    twin.load(SavedState().joined(body=model.state()).part("body"))
    for angles in data[samples:]:
        actions = [each.learn(angles, ARM.forward(angles), angles + 0.4) for each in (model, twin)]
        np.testing.assert_array_equal(*actions)
    for name, array in model.state().arrays.items():
        np.testing.assert_array_equal(array, twin.state().arrays[name])


def test_refuses_snapshots_of_another_robot() -> None:
    """And keeps what it has."""
    model = taught(CONFIG, 20)
    before = model.predict(HOME + 0.1)
    whole, other = model.state(), body(joints=4).state()
    with pytest.raises(GoalBabblingError):
        model.load(other)
    for part in ("forward_", "offsets_", "range_"):
        mixed = {
            name: other.arrays[name] if name.startswith(part) else array
            for name, array in whole.arrays.items()
        }
        with pytest.raises(GoalBabblingError):
            model.load(SavedState(mixed, whole.settings))
    np.testing.assert_array_equal(model.predict(HOME + 0.1), before)
