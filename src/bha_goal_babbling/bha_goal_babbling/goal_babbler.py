"""Online goal babbling, asked and told.

    babbler = GoalBabbler(config, goals, home_action, home_outcome, low, high, rng)
    while True:
        action = babbler.ask()               # what to execute now
        measured, outcome = robot(action)    # what was executed, and what came of it
        babbler.tell(measured, outcome)      # one example learned

Every command is the present inverse model's answer to a target on a path to some goal, with
exploratory noise on it: q_t = g(x*_t) + E_t(x*_t) (equation 3 of the article). The example
(q_t, x_t) that comes of it is weighted and learned at once. Now and then a movement goes home
instead, straight in the space of actions and without noise, which keeps the solutions from
drifting. Nothing here knows time, files or a robot.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from bha_goal_babbling.arrays import FloatArray, vector
from bha_goal_babbling.babbler_config import GoalBabblerConfig
from bha_goal_babbling.errors import InvalidArrayError, InvalidConfigError, WrongOrderError
from bha_goal_babbling.exploration_noise import ExplorationNoise
from bha_goal_babbling.goal_paths import GoalPaths
from bha_goal_babbling.inverse_model import InverseModel
from bha_goal_babbling.knowledge import Knowledge
from bha_goal_babbling.monitored_paths import MonitoredGoalPaths
from bha_goal_babbling.movements import Movements, restored_targets
from bha_goal_babbling.noise_amplitude import NoiseAmplitude
from bha_goal_babbling.random_state import generator_settings, restored_generator
from bha_goal_babbling.recent_error import RecentError
from bha_goal_babbling.saved_state import SavedState
from bha_goal_babbling.target_source import TargetSource


class GoalBabbler:
    """Learns by trying: which action brings which outcome.

    Parameters
    ----------
    config : GoalBabblerConfig
        All settings.
    goals : array_like or TargetSource
        The goal set, in the unit of outcomes, shape (G, n); or another source of targets.
    home_action : array_like
        Action at which learning starts and to which it returns, shape (m,).
    home_outcome : array_like
        Outcome of the home action, shape (n,). The robot is at home when learning starts.
    action_low, action_high : array_like
        Limits that no action exceeds, shape (m,).
    rng : numpy.random.Generator
        Source of all randomness, as `numpy.random.default_rng(seed)` makes it.
    model : InverseModel, optional
        The inverse model to train, in scaled units; local linear maps by default.

    Raises
    ------
    InvalidArrayError, InvalidConfigError
        If shapes do not fit together, a number is not finite, or home is outside of the limits.
    """

    def __init__(
        self,
        config: GoalBabblerConfig,
        goals: ArrayLike | TargetSource,
        home_action: ArrayLike,
        home_outcome: ArrayLike,
        action_low: ArrayLike,
        action_high: ArrayLike,
        rng: np.random.Generator,
        *,
        model: InverseModel | None = None,
    ) -> None:
        self.config = config
        self._home_action = vector("home_action", home_action)
        self._home_outcome = vector("home_outcome", home_outcome)
        m, n = self._home_action.size, self._home_outcome.size
        self._low = vector("action_low", action_low, m)
        self._high = vector("action_high", action_high, m)
        if not ((self._low <= self._home_action) & (self._home_action <= self._high)).all():
            raise InvalidConfigError(
                f"home_action must lie within the limits, got {self._home_action.tolist()} "
                f"for {self._low.tolist()} to {self._high.tolist()}"
            )
        targets = goals if isinstance(goals, TargetSource) else self._paths(goals)
        if targets.size != n:
            raise InvalidArrayError(f"goals have {targets.size} coordinates, home_outcome has {n}")
        self._movements = Movements(
            targets,
            self._home_action,
            self._home_outcome,
            config.home_probability,
            config.path_steps,
        )
        self._knowledge = Knowledge(
            config, self._home_action, self._home_outcome, self._low, self._high, model
        )
        self._rng = rng
        self._noise = ExplorationNoise(config.noise_spread, config.noise_step, m, n, rng)
        self._amplitude = NoiseAmplitude(
            config.noise_spread, config.noise_floor, config.noise_per_error
        )
        self._noise_origin = np.zeros(n) if config.noise_origin == "zero" else self._home_outcome
        self._pending: FloatArray | None = None
        self._samples = 0
        self._error = RecentError(config.error_window)

    @property
    def movements(self) -> int:
        """Number of finished movements, those towards home counted too."""
        return self._movements.count

    @property
    def samples(self) -> int:
        """Number of actions that were told to have been executed."""
        return self._samples

    @property
    def local_maps(self) -> int:
        """Number of local models."""
        return self._knowledge.model.count

    @property
    def recent_error(self) -> float:
        """Distance between target and outcome at the ends of movements, recently [outcome unit].

        The running mean of |x_t - x*_t| at the last step of movements, over the last
        `error_window` or so of them; those towards home and samples told with `learn=False` are
        left out. The exploratory noise is part of it, so it stays somewhat above the error of
        `inverse`. NaN before the first such end.
        """
        return self._error.value

    @property
    def going_home(self) -> bool:
        """Whether the present movement goes home."""
        return self._movements.going_home

    @property
    def home_outcome(self) -> FloatArray:
        """Outcome of the home action, shape (n,) [outcome unit]."""
        return self._home_outcome.copy()

    @property
    def target(self) -> FloatArray:
        """Target x*_t of the action asked for, shape (n,) [outcome unit]; home on the way home."""
        return self._movements.target.copy()

    @property
    def model(self) -> InverseModel:
        """The inverse model, in scaled units."""
        return self._knowledge.model

    def ask(self) -> FloatArray:
        """Return the action to execute now, shape (m,), within the limits.

        The same action comes again until it is told what came of it.
        """
        if self._pending is None:
            known = self._knowledge
            self._movements.prepare(known.action, known.outcome, self._rng)
            going_home = self._movements.going_home
            wanted = self._movements.home_step if going_home else self._explored_action()
            self._pending = known.reading(wanted)
        return self._pending.copy()

    def tell(self, action: ArrayLike, outcome: ArrayLike, learn: bool = True) -> None:
        """Learn what came of the action that was asked for, and go on to the next step.

        Parameters
        ----------
        action : array_like
            The action that was really executed, as measured, shape (m,).
        outcome : array_like
            What came of it, shape (n,).
        learn : bool
            False for a sample that is not to be trusted: it is passed over.

        Raises
        ------
        WrongOrderError
            If nothing was asked since the last call.
        InvalidArrayError
            If a shape is wrong or a number is not finite.
        """
        if self._pending is None:
            raise WrongOrderError("tell was called without ask; call ask first")
        action, outcome = self._example(action, outcome)
        outcome_step = outcome - self._knowledge.outcome
        miss = outcome - self._movements.target
        # Also across movements the last step is carried on, so that no example is lost.
        if learn:
            going_home = self._movements.going_home
            target_step = None if going_home else self._movements.target_step
            self._knowledge.learn(action, outcome, self._pending, target_step)
        else:
            self._knowledge.pass_over(action, outcome)
        self._pending = None
        self._samples += 1
        over = self._movements.advance(outcome_step, outcome if learn else None)
        if over and learn and not self._movements.going_home:
            self._error.add(math.sqrt(float(miss.dot(miss))))

    def pause(self) -> None:
        """Take note that the robot has come to rest, or was elsewhere, since the last example."""
        self._knowledge.pause()

    def practise(self, action: ArrayLike, outcome: ArrayLike) -> None:
        """Learn an example that came of somebody else's goal, and stay at the present step.

        Nothing is known of what was intended, so it is weighted like a step towards home: by what
        it has moved since the example before.

        Parameters
        ----------
        action, outcome : array_like
            What was measured, shape (m,), and what came of it, shape (n,).

        Raises
        ------
        InvalidArrayError
            If a shape is wrong or a number is not finite.
        """
        self._knowledge.learn(*self._example(action, outcome), None, None)

    def follow_offsets(self, action: ArrayLike, outcome: ArrayLike) -> None:
        """Take from such an example what the sensors of the action are off by, and nothing else.

        Without a body model there is nothing to take.

        Parameters
        ----------
        action, outcome : array_like
            As for `practise`.

        Raises
        ------
        InvalidArrayError
            If a shape is wrong or a number is not finite.
        """
        self._knowledge.follow_offsets(*self._example(action, outcome))

    def inverse(
        self,
        goal: ArrayLike,
        low: FloatArray | float = -np.inf,
        high: FloatArray | float = np.inf,
    ) -> FloatArray:
        """Return g(x*), refined where there is a body model, without noise, within the limits.

        Parameters
        ----------
        goal : array_like
            One goal, shape (n,), or many, shape (N, n), in the unit of outcomes.
        low, high : array, optional
            Ends to which actions were seen to come just now, shape (m,), for one goal; a body
            model lets other entries make up for them.

        Returns
        -------
        array
            One action, shape (m,), or many, shape (N, m).
        """
        return self._knowledge.inverse(goal, low, high)

    def state(self) -> SavedState:
        """Return everything that `restore` needs, the state of the generator included."""
        pending = [] if self._pending is None else [self._pending]
        arrays = {
            "home_action": self._home_action,
            "home_outcome": self._home_outcome,
            "action_low": self._low,
            "action_high": self._high,
            "pending": np.array(pending),
        }
        settings = {
            "config": self.config.as_mapping(),
            "generator": generator_settings(self._rng),
            "samples": self._samples,
        }
        known = self._knowledge.state()
        return SavedState({**arrays, **known.arrays}, {**settings, **known.settings}).joined(
            movements=self._movements.state(),
            noise=self._noise.state(),
            error=self._error.state(),
        )

    @classmethod
    def restore(cls, state: SavedState) -> "GoalBabbler":
        """Return the learner whose snapshot this is; it continues bit for bit.

        Raises
        ------
        GoalBabblingError, KeyError
            If something in the snapshot is missing or does not fit together.
        """
        arrays, settings = state.arrays, state.settings
        config = GoalBabblerConfig.from_mapping(settings["config"])
        babbler = cls(
            config,
            restored_targets(state.part("movements")),
            arrays["home_action"],
            arrays["home_outcome"],
            arrays["action_low"],
            arrays["action_high"],
            np.random.default_rng(0),
        )
        babbler._rng = restored_generator(settings["generator"])
        babbler._knowledge.load(state)
        babbler._movements.load(state.part("movements"))
        babbler._noise.load(state.part("noise"))
        babbler._error.load(state.part("error"))
        if len(arrays["pending"]):
            babbler._pending = vector("pending", arrays["pending"][0], babbler._home_action.size)
        babbler._samples = int(settings["samples"])
        return babbler

    def _explored_action(self) -> FloatArray:
        """Return g(x*) + E(x*), shape (m,), equation 3; without noise where the robot rests."""
        target = self._movements.target
        self._noise.advance(self._rng)
        noise = self._noise.at((target - self._noise_origin) / self.config.outcome_scale)
        moves = self._movements
        share = 0.0 if moves.resting else self._amplitude.share(moves.goal_error)
        return self._knowledge.solution(target, explores=True) + share * noise

    def _example(self, action: ArrayLike, outcome: ArrayLike) -> tuple[FloatArray, FloatArray]:
        return (
            vector("action", action, self._home_action.size),
            vector("outcome", outcome, self._home_outcome.size),
        )

    def _paths(self, goals: ArrayLike) -> TargetSource:
        config = self.config
        if not config.monitors_goals:
            return GoalPaths(goals, config.path_steps)
        return MonitoredGoalPaths(
            goals,
            config.path_steps,
            self._home_outcome,
            config.goal_candidates,
            config.abort_distance,
            config.stay_steps,
            config.rest_steps,
            config.rest_error,
        )
