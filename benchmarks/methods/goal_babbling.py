"""Goal babbling behind the interface of the compared methods."""

import numpy as np

from benchmarks.methods.method import Method
from benchmarks.methods.world import World
from bha_goal_babbling.arrays import FloatArray
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.goal_babbler import GoalBabbler
from bha_goal_babbling.target_source import TargetSource


class GoalBabbling(Method):
    """Online goal babbling.

    Parameters
    ----------
    world : World
        Where it acts.
    rng : numpy.random.Generator
        Source of all randomness.
    config : GoalBabblerConfig
        Its settings.
    targets : TargetSource, optional
        Where movements go; paths between random goals of the world by default.
    """

    def __init__(
        self,
        world: World,
        rng: np.random.Generator,
        config: GoalBabblerConfig,
        targets: TargetSource | None = None,
    ) -> None:
        super().__init__(world)
        self._babbler = GoalBabbler(
            config,
            world.goals if targets is None else targets,
            world.home_action,
            world.home_outcome,
            world.action_low,
            world.action_high,
            rng,
        )

    @property
    def movements(self) -> int:
        """Number of finished movements, those towards home counted too."""
        return self._babbler.movements

    def step(self) -> None:
        """Execute and learn one action."""
        action = self._babbler.ask()
        self._babbler.tell(action, self.world.execute(action))

    def inverse(self, goals: FloatArray) -> FloatArray:
        """Return g; see `Method`."""
        return self._babbler.inverse(goals)
