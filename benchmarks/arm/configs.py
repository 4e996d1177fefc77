"""Settings of goal babbling that the tables share, for planar arms of 1 m."""

from bha_goal_babbling.babbler_config import GoalBabblerConfig

ARTICLE = GoalBabblerConfig(map_distance=0.1, learning_rate=0.1, noise_spread=0.05, noise_step=0.01)
"""Goal babbling with the article's slow noise and small steps."""

FAST = GoalBabblerConfig()
"""Goal babbling with fresh noise and large steps: fast and accurate."""

RLS = GoalBabblerConfig.rls()
"""RLS goal babbling."""
