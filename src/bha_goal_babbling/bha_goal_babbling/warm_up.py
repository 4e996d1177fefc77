"""Machine code is made, or read from disk, at the first call: here, before a robot waits for it."""

import numpy as np

from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.task import Task


def warm_up(task: Task) -> None:
    """Let a babbler explore a little on made-up outcomes, and forget it.

    First calls take a second, and several where nothing was compiled yet. In lockstep that is
    longer than the controller waits for a command; in real time the robot would go on without one.
    """
    outcomes = task.goals()[:3]
    babbler = GoalBabbler(
        task.config,
        task.goals(),
        task.home_action,
        outcomes[0],
        task.action_low,
        task.action_high,
        np.random.default_rng(0),
    )
    for outcome in outcomes:
        babbler.tell(babbler.ask(), outcome)
    babbler.practise(task.home_action, outcomes[0])
    babbler.inverse(outcomes[0])
