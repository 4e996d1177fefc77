"""Online goal babbling in machine code, for robots that are machine code as well.

    babbler = CompiledGoalBabbler(config, goals, home, tip, low, high, rng, forward)
    babbler.run(20_000)
    actions = babbler.inverse(goals)

The same learner as `GoalBabbler`, its reference: it draws the same random numbers in the same
order and computes the same formulas, some hundred times faster, because question, robot and lesson
are one loop that never returns to Python. What it leaves out are maps too far away to matter (see
`compiled_maps`), snapshots, and robots that run in another process.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from bha_goal_babbling import compiled_kernels as kernels
from bha_goal_babbling.arrays import FloatArray, matrix, vector
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.compiled_maps import CUTOFF, CompiledMaps
from bha_goal_babbling.direction_sampling import DirectionTargets
from bha_goal_babbling.errors import InvalidArrayError, InvalidConfigError
from bha_goal_babbling.exploration_noise import ExplorationNoise
from bha_goal_babbling.local_linear_map import LocalLinearMaps
from bha_goal_babbling.sample_weights import MEAN_HEAD_START, MEAN_RATE, MEAN_START

Forward = Callable[[FloatArray, FloatArray], None]
"""A robot: (action, shape (m,); to be filled with the outcome, shape (n,)), compiled by numba.

With `numba.cfunc(compiled_kernels.FORWARD_SIGNATURE)` the loop's machine code is taken from the
cache on disk; with `numba.njit` it is compiled anew in every process, which takes seconds.
"""

_CHUNK = 65_536  # samples at once, so that outcomes nobody asked for take little memory
_NEVER = np.iinfo(np.int64).max


class CompiledGoalBabbler:
    """Learns by trying: which action brings which outcome.

    Parameters
    ----------
    config : GoalBabblerConfig
        All settings.
    goals : array_like or DirectionTargets
        The goal set, in the unit of outcomes, shape (G, n); or directions.
    home_action : array_like
        Action at which learning starts and to which it returns, shape (m,).
    home_outcome : array_like
        Outcome of the home action, shape (n,). The robot is at home when learning starts.
    action_low, action_high : array_like
        Limits that no action exceeds, shape (m,).
    rng : numpy.random.Generator
        Source of all randomness, as `numpy.random.default_rng(seed)` makes it.
    forward : Forward
        The robot.
    cutoff : float
        Share of the largest responsibility below which a map does not count; 0 for the sum over
        all maps, as in `GoalBabbler`.

    Raises
    ------
    InvalidArrayError, InvalidConfigError
        If shapes do not fit together, a number is not finite, or home is outside of the limits.
    """

    def __init__(
        self,
        config: GoalBabblerConfig,
        goals: ArrayLike | DirectionTargets,
        home_action: ArrayLike,
        home_outcome: ArrayLike,
        action_low: ArrayLike,
        action_high: ArrayLike,
        rng: np.random.Generator,
        forward: Forward,
        *,
        cutoff: float = CUTOFF,
    ) -> None:
        self.config = config
        self._rng = rng
        self._forward = forward
        _check_supported(config)
        action, outcome = vector("home_action", home_action), vector("home_outcome", home_outcome)
        m, n = action.size, outcome.size
        low, high = vector("action_low", action_low, m), vector("action_high", action_high, m)
        if not ((low <= action) & (action <= high)).all():
            raise InvalidConfigError(
                f"home_action must lie within the limits, got {action.tolist()} "
                f"for {low.tolist()} to {high.tolist()}"
            )
        if isinstance(goals, DirectionTargets):
            if goals.size != n:
                raise InvalidArrayError(
                    f"goals have {goals.size} coordinates, home_outcome has {n}"
                )
            direction_step, goal_set = goals.step, np.empty((0, n))
        else:
            direction_step, goal_set = 0.0, matrix("goals", goals, n)
            if len(goal_set) < 2:
                raise InvalidConfigError(
                    f"the goal set must hold at least 2 goals, got {len(goal_set)}"
                )
        noise = ExplorationNoise(config.noise_spread, config.noise_step, m, n, rng)
        self._task = kernels.Task(
            goals=goal_set,
            direction_step=direction_step,
            path_steps=config.path_steps,
            home_probability=float(config.home_probability),
            home_action=action,
            home_outcome=outcome,
            low=low,
            high=high,
            noise_origin=np.zeros(n) if config.noise_origin == "zero" else outcome,
            noise_step=float(config.noise_step),
            noise_keep=noise.keep,
            action_scale=float(config.action_scale),
            outcome_scale=float(config.outcome_scale),
            action_resolution=config.action_resolution / config.action_scale,
            outcome_resolution=config.outcome_resolution / config.outcome_scale,
            use_direction=config.direction != "none",
            use_efficiency=config.efficiency != "none",
            relative=config.efficiency == "relative",
            limit=math.inf if config.efficiency_limit is None else float(config.efficiency_limit),
            mean_rate=MEAN_RATE,
            mean_head_start=MEAN_HEAD_START,
        )
        self._state = kernels.State(
            action=action.copy(),
            outcome=outcome.copy(),
            previous=outcome.copy(),
            target=outcome.copy(),
            start=np.zeros(max(m, n)),
            advance=np.zeros(n),
            noise=noise.state().arrays["entries"],
            mean=np.array([MEAN_START]),
            # Learning starts at home, as after a movement home.
            numbers=np.array([1, 1, 0, 0, -1, 0]),
            new_action=np.zeros(m),
            scaled_action=np.zeros(m),
            new_outcome=np.zeros(n),
            scaled_outcome=np.zeros(n),
        )
        self._maps = CompiledMaps(
            config.map_distance / config.outcome_scale,
            config.learning_rate,
            outcome / config.outcome_scale,
            action / config.action_scale,
            cutoff,
        )
        self._samples = 0

    @property
    def movements(self) -> int:
        """Number of finished movements, those towards home counted too."""
        return int(self._state.numbers[kernels.MOVEMENTS])

    @property
    def samples(self) -> int:
        """Number of actions that were executed."""
        return self._samples

    @property
    def local_maps(self) -> int:
        """Number of local models."""
        return self._maps.count

    @property
    def model(self) -> CompiledMaps:
        """The inverse model, in scaled units."""
        return self._maps

    def run(self, samples: int) -> FloatArray:
        """Babble, and return the outcomes [outcome unit], shape (samples, n)."""
        visited = np.empty((samples, self._state.outcome.size))
        self._babble(visited, _NEVER)
        return visited

    def run_movements(self, movements: int) -> None:
        """Babble until so many more movements are finished."""
        end = self.movements + movements
        visited = np.empty((_CHUNK, self._state.outcome.size))
        while self.movements < end:
            self._babble(visited, end)

    def inverse(self, goal: ArrayLike) -> FloatArray:
        """Return g(x*) without noise, within the limits.

        Parameters
        ----------
        goal : array_like
            One goal, shape (n,), or many, shape (N, n), in the unit of outcomes.

        Returns
        -------
        array
            One action, shape (m,), or many, shape (N, m).
        """
        n = self._state.outcome.size
        one = np.ndim(goal) != 2
        goals = vector("goal", goal, n)[np.newaxis] if one else matrix("goal", goal, n)
        actions = self._maps.predict_many(goals / self.config.outcome_scale)
        actions *= self.config.action_scale
        actions = np.minimum(np.maximum(actions, self._task.low), self._task.high)
        return actions[0] if one else actions

    def _babble(self, visited: FloatArray, movements: int) -> None:
        """Fill `visited`, or stop early at a number of movements."""
        made = 0
        while made < len(visited) and self.movements < movements:
            self._maps.make_room()
            more = kernels.babble(
                self._maps.arrays,
                self._task,
                self._state,
                self._forward,
                self._rng,
                movements,
                visited[made:],
            )
            made += more
            self._samples += more


def _check_supported(config: GoalBabblerConfig) -> None:
    """Refuse what only `GoalBabbler` can do: this loop is the article's method and no other."""
    if (
        config.model != LocalLinearMaps.kind
        or config.monitors_goals
        or config.forward_model != "none"
    ):
        raise InvalidConfigError(
            "the compiled loop knows the gradient method only: use GoalBabbler for model "
            f"{config.model!r}, for settings that look at the errors of goals, and for forward "
            "models"
        )
