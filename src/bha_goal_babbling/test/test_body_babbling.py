"""Goal babbling with a forward model as a whole, on an arm with what makes a trunk hard."""

import math

import numpy as np
import pytest

from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.planar_arm import PlanarArm
from bha_goal_babbling.saved_state import SavedState

PLAIN = {"process_noise": 0.02, "outcome_noise": 0.004}
BODY = {**PLAIN, "forward_model": "polynomial"}
OFFSETS = {**BODY, "offset_spread": 0.05, "offset_samples": 500.0}


class SlippingArm(PlanarArm):
    """Five joints whose sensors wander; the first one comes to an end soon; a tip with noise."""

    def __init__(self, seed: int, spread: float = 0.05, end: float = 0.15) -> None:
        super().__init__(5)
        self._rng = np.random.default_rng(seed)
        self._spread = spread
        self.offsets = np.zeros(5)
        self.high = np.array([self.home()[0] + end, 3.0, 3.0, 3.0, 3.0])

    def hold(self, command: FloatArray) -> FloatArray:
        """Return the angles at which the sensors read a command, or the joint is at its end."""
        return np.minimum(command - self.offsets, self.high)

    def execute(self, command: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the angles as they are read, and the tip."""
        rho = math.exp(-1 / 500.0)
        self.offsets = rho * self.offsets
        self.offsets += self._spread * math.sqrt(1 - rho**2) * self._rng.standard_normal(5)
        angles = self.hold(command)
        tip = self.forward(angles) + 0.002 * self._rng.standard_normal(2)
        return angles + self.offsets, tip


def learner(
    arm: SlippingArm, seed: int, settings: dict[str, object], limit: float = 4.0
) -> GoalBabbler:
    """Return a learner whose commands stay within `limit` [rad] of home."""
    home = arm.home()
    return GoalBabbler(
        GoalBabblerConfig.rls(**settings),
        arm.goal_grid(),
        home,
        arm.forward(home),
        home - limit,
        home + limit,
        np.random.default_rng(seed),
    )


def babble(arm: SlippingArm, babbler: GoalBabbler, samples: int) -> list[FloatArray]:
    actions = []
    for _ in range(samples):
        actions.append(babbler.ask())
        babbler.tell(*arm.execute(actions[-1]))
    return actions


def error(arm: SlippingArm, babbler: GoalBabbler) -> float:
    """Return the mean distance to the goals of what the answers bring just now [m]."""
    goals = arm.goal_grid()
    tips = arm.forward([arm.hold(command) for command in babbler.inverse(goals)])
    return float(np.linalg.norm(tips - goals, axis=1).mean())


def error_of(seed: int, settings: dict[str, object], **robot: float) -> float:
    """Return the mean error at five times after 2000 samples [m]."""
    arm = SlippingArm(seed, **robot)
    babbler = learner(arm, seed, settings)
    babble(arm, babbler, 2000)
    errors = []
    for _ in range(5):
        babble(arm, babbler, 100)
        errors.append(error(arm, babbler))
    return float(np.mean(errors))


def test_exploration_goes_where_an_answer_in_use_would_not() -> None:
    """What the body model does not know holds answers back, and exploration is to find it out."""
    arm = SlippingArm(0)
    quiet = {**BODY, "noise_spread": 1e-9, "noise_step": 1e-9, "home_probability": 0.0}
    babbler = learner(arm, 0, quiet)
    rng, away = np.random.default_rng(0), []
    for _ in range(200):
        asked = babbler.ask()
        away.append(np.abs(asked - babbler.inverse(babbler.target)).max())
        babbler.tell(*arm.execute(asked + 0.1 * rng.standard_normal(5)))
    assert np.median(away[20:]) > 1e-3


@pytest.mark.parametrize("seed", range(3))
def test_sensors_that_wander_are_seen_through(seed: int) -> None:
    """About 4 mm are left of 20 to 60: neither the inverse nor the forward model alone does it."""
    both, forward, inverse = (error_of(seed, settings) for settings in (OFFSETS, BODY, PLAIN))
    assert inverse > 0.015
    assert both < 0.01
    assert both < 0.4 * min(inverse, forward)


def test_a_joint_at_its_end_is_made_up_for() -> None:
    """Home is the end of the first joint: about 1 mm is left of 7 (median of 5 robots)."""
    errors = np.empty((5, 2))
    for seed, row in enumerate(errors):
        for column, settings in enumerate((BODY, PLAIN)):
            arm = SlippingArm(seed, spread=0.0, end=0.0)
            babbler = learner(arm, seed, settings)
            babble(arm, babbler, 3000)
            row[column] = error(arm, babbler)
    body, plain = np.median(errors, axis=0)
    assert body < 0.003
    assert body < 0.4 * plain


@pytest.mark.parametrize("asked", [False, True])
@pytest.mark.parametrize("samples", [0, 1, 3, 200])
def test_a_snapshot_goes_on_bit_for_bit(samples: int, asked: bool) -> None:
    arm, twin_arm = SlippingArm(4), SlippingArm(4)
    babbler = learner(arm, 4, OFFSETS)
    babble(arm, babbler, samples)
    babble(twin_arm, learner(twin_arm, 4, OFFSETS), samples)
    if asked:
        babbler.ask()
    twin = GoalBabbler.restore(babbler.state())
    np.testing.assert_array_equal(babble(arm, babbler, 200), babble(twin_arm, twin, 200))
    goals = arm.goal_grid()
    np.testing.assert_array_equal(babbler.inverse(goals), twin.inverse(goals))


def test_many_goals_are_answered_as_one_by_one() -> None:
    arm = SlippingArm(5)
    babbler = learner(arm, 5, OFFSETS)
    babble(arm, babbler, 300)
    goals = arm.goal_grid()
    np.testing.assert_array_equal(babbler.inverse(goals), [babbler.inverse(g) for g in goals])


def test_commands_and_answers_keep_the_limits() -> None:
    """Whatever the offsets are; the rest has to be made up for by others."""
    arm = SlippingArm(6)
    babbler = learner(arm, 6, OFFSETS, limit=0.2)
    actions = np.array(babble(arm, babbler, 500))
    answers = babbler.inverse(arm.goal_grid())
    for each in (actions, answers):
        assert (each >= arm.home() - 0.2).all()
        assert (each <= arm.home() + 0.2).all()


def test_practice_teaches_the_body_too() -> None:
    """Sensors slip by 0.1 rad at once: examples of somebody else's goals tell of that."""
    arm = SlippingArm(7, spread=0.0)
    babbler = learner(arm, 7, OFFSETS)
    babble(arm, babbler, 2000)
    arm.offsets, arm._spread = 0.1 * np.array([1.0, -1.0, 1.0, 1.0, -1.0]), 0.0
    before = error(arm, babbler)
    slipped, goals = arm.offsets.copy(), arm.goal_grid()
    for goal in np.random.default_rng(0).permutation(goals)[:60]:
        command = babbler.inverse(goal)
        angles = arm.hold(command)
        babbler.practise(angles + slipped, arm.forward(angles))
    after = error(arm, babbler)
    assert before > 0.03
    assert after < 0.3 * before


def test_a_pause_is_passed_on_to_the_body() -> None:
    """And nothing else changes: not the action that was asked for, not what is known."""
    arm = SlippingArm(10)
    babbler = learner(arm, 10, OFFSETS)
    babble(arm, babbler, 50)
    asked, answers = babbler.ask(), babbler.inverse(arm.goal_grid())
    before = babbler.state().arrays
    assert (len(before["body_forward_history"]), len(before["body_range_watch_commands"])) == (2, 4)
    babbler.pause()
    after = babbler.state().arrays
    assert (len(after["body_forward_history"]), len(after["body_range_watch_commands"])) == (0, 0)
    np.testing.assert_array_equal(babbler.ask(), asked)
    np.testing.assert_array_equal(babbler.inverse(arm.goal_grid()), answers)


def test_samples_that_are_not_trusted_teach_the_body_nothing() -> None:
    arm = SlippingArm(8)
    babbler = learner(arm, 8, OFFSETS)
    babble(arm, babbler, 100)

    def body() -> SavedState:
        return babbler.state().part("body")

    before, goals = body(), arm.goal_grid()
    answers = babbler.inverse(goals)
    for _ in range(20):
        babbler.ask()
        babbler.tell(np.full(5, 2.0), np.ones(2), learn=False)
    under_way = {"forward_history", "range_watch_commands", "range_watch_action"}
    for name in before.arrays.keys() - under_way:
        np.testing.assert_array_equal(before.arrays[name], body().arrays[name])
    assert (len(body().arrays["forward_history"]), len(body().arrays["range_watch_commands"])) == (
        0,
        0,
    )
    np.testing.assert_array_equal(babbler.inverse(goals), answers)
    babbler.ask()
    babbler.tell(np.full(5, 2.0), np.ones(2))
    assert not np.array_equal(before.arrays["offsets_values"], body().arrays["offsets_values"])


def test_without_a_forward_model_nothing_of_it_is_there() -> None:
    """The method as before: the other settings do not matter, and no snapshot tells of a body."""
    arm, twin_arm = SlippingArm(9), SlippingArm(9)
    babbler = learner(arm, 9, PLAIN)
    twin = learner(twin_arm, 9, {"process_noise": 0.02, "outcome_noise": 1.0, "offset_spread": 1.0})
    np.testing.assert_array_equal(babble(arm, babbler, 300), babble(twin_arm, twin, 300))
    assert not [name for name in babbler.state().arrays if name.startswith("body")]
