"""Inverse and body model together: who answers, who learns what, snapshots."""

from typing import Any

import numpy as np
import pytest

from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.body_model import BodyModel
from bha_goal_babbling.errors import GoalBabblingError
from bha_goal_babbling.knowledge import Knowledge
from bha_goal_babbling.local_linear_map import LocalLinearMaps
from bha_goal_babbling.planar_arm import PlanarArm
from bha_goal_babbling.scaled_model import ScaledModel

ARM = PlanarArm(4)
HOME, TIP = ARM.home(), ARM.forward(ARM.home())
PLAIN = {"learning_rate": 0.5, "action_scale": 1.5, "outcome_scale": 0.5}
BODY = {**PLAIN, "forward_model": "polynomial", "offset_spread": 0.05, "offset_samples": 50.0}


def knowledge(settings: dict[str, Any], width: float = 3.0) -> Knowledge:
    config = GoalBabblerConfig(**settings)
    return Knowledge(config, HOME, TIP, HOME - width, HOME + width)


def teach(known: Knowledge, samples: int, seed: int = 0) -> None:
    """Let it learn what comes of angles that read 0.04 too much."""
    rng = np.random.default_rng(seed)
    for angles in HOME + rng.uniform(-0.3, 0.3, (samples, 4)):
        known.learn(angles + 0.04, ARM.forward(angles), angles, rng.uniform(-0.1, 0.1, 2))


def test_begins_at_home() -> None:
    for settings in (PLAIN, BODY):
        known = knowledge(settings)
        np.testing.assert_allclose(known.inverse([0.2, 0.3]), HOME, rtol=1e-14)
        np.testing.assert_array_equal(known.action, HOME)
        np.testing.assert_array_equal(known.outcome, TIP)


def test_without_a_body_model_it_is_the_scaled_model() -> None:
    known, config = knowledge(PLAIN), GoalBabblerConfig(**PLAIN)
    plain, action, outcome = ScaledModel.at_home(config, HOME, TIP), HOME, TIP
    rng = np.random.default_rng(1)
    for angles in HOME + rng.uniform(-0.3, 0.3, (100, 4)):
        tip, intended = ARM.forward(angles), rng.uniform(-0.1, 0.1, 2)
        known.learn(angles, tip, None, intended)
        plain.learn(angles, tip, angles - action, tip - outcome, intended)
        action, outcome = angles, tip
    goals = ARM.goal_grid()
    np.testing.assert_array_equal(known.inverse(goals), plain.predict_many(goals))
    np.testing.assert_array_equal(known.solution(goals[3]), plain.predict(goals[3]))
    np.testing.assert_array_equal(known.reading(HOME + 0.1), HOME + 0.1)


def test_with_a_body_model_answers_are_refined_and_told_as_readings() -> None:
    """The inverse model learns the corrected action, and chooses where the refinement begins."""
    known, config = knowledge(BODY), GoalBabblerConfig(**BODY)
    inverse = ScaledModel.at_home(config, HOME, TIP)
    body = BodyModel(config, HOME, TIP, HOME - 3.0, HOME + 3.0)
    action, outcome = HOME, TIP
    rng = np.random.default_rng(2)
    for angles in HOME + rng.uniform(-0.3, 0.3, (100, 4)):
        tip = ARM.forward(angles)
        known.learn(angles + 0.04, tip, angles, None)
        corrected = body.learn(angles + 0.04, tip, angles)
        inverse.learn(corrected, tip, corrected - action, tip - outcome, None)
        action, outcome = corrected, tip
    np.testing.assert_array_equal(known.action, action)
    goal = TIP + np.array([-0.05, 0.1])
    refined = body.refine(inverse.predict(goal), goal)
    assert np.abs(refined - inverse.predict(goal)).max() > 1e-3
    assert np.abs(body.offsets).max() > 1e-3
    np.testing.assert_array_equal(known.solution(goal), refined)
    np.testing.assert_array_equal(known.inverse(goal), refined + body.offsets)
    bold = body.refine(inverse.predict(goal), goal, explores=True)
    assert np.abs(bold - refined).max() > 1e-6
    np.testing.assert_array_equal(known.solution(goal, explores=True), bold)


@pytest.mark.parametrize("settings", [PLAIN, BODY], ids=["plain", "body"])
def test_answers_keep_the_limits(settings: dict[str, Any]) -> None:
    """One goal or many, and whatever is turned into a reading."""
    known = knowledge(settings, width=0.1)
    teach(known, 200)
    goals = ARM.goal_grid()
    answers = known.inverse(goals)
    np.testing.assert_allclose(answers, [known.inverse(goal) for goal in goals], rtol=1e-12)
    assert (np.abs(answers - HOME) <= 0.1 + 1e-15).all()
    assert np.abs(answers - HOME).max() > 0.09
    np.testing.assert_array_equal(known.reading(HOME + 5.0), HOME + 0.1)
    with pytest.raises(GoalBabblingError, match="goal"):
        known.inverse(np.zeros(3))


@pytest.mark.parametrize("settings", [PLAIN, BODY], ids=["plain", "body"])
def test_what_is_passed_over_is_where_the_next_example_starts(settings: dict[str, Any]) -> None:
    known, twin = knowledge(settings), knowledge(settings)
    for each in (known, twin):
        teach(each, 30)
    goals = ARM.goal_grid()
    before = known.inverse(goals)
    known.pass_over(HOME, TIP)
    np.testing.assert_array_equal(known.inverse(goals), before)
    for each in (known, twin):
        each.learn(HOME + 0.1, ARM.forward(HOME + 0.1), HOME + 0.1, None)
    assert not np.array_equal(known.inverse(goals), twin.inverse(goals))


@pytest.mark.parametrize("settings", [PLAIN, BODY], ids=["plain", "body"])
@pytest.mark.parametrize("samples", [0, 1, 50])
def test_continues_bit_for_bit(settings: dict[str, Any], samples: int) -> None:
    known, twin = knowledge(settings), knowledge(settings)
    teach(known, samples)
    twin.load(known.state())
    goals = ARM.goal_grid()
    for each in (known, twin):
        teach(each, 50, seed=1)
    np.testing.assert_array_equal(known.inverse(goals), twin.inverse(goals))
    np.testing.assert_array_equal(known.action, twin.action)
    np.testing.assert_array_equal(known.outcome, twin.outcome)


def test_trains_the_model_that_it_is_given() -> None:
    config = GoalBabblerConfig(**PLAIN)
    maps = LocalLinearMaps(0.1, 0.5, TIP / 0.5, HOME / 1.5)
    known = Knowledge(config, HOME, TIP, HOME - 3.0, HOME + 3.0, maps)
    teach(known, 100)
    assert known.model is maps
    assert maps.count > 1
