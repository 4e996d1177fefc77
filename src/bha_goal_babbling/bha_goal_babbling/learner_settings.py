"""What can be set about the learner apart from its task."""

from dataclasses import dataclass

from bha_common.settings import check_settings, setting


@dataclass(frozen=True)
class LearnerSettings:
    """Times and tolerances of babbling and reaching, all in robot time."""

    command_period: float = setting(
        0.5, "Time between two length commands [s]; a multiple of the control period", low=0.02
    )
    step_periods: int = setting(
        1, "Length commands that one step of exploration lasts", low=1, high=1000
    )
    observation_span: float = setting(
        0.5, "Time over which lengths and tip are averaged for one observation [s]", low=1e-3
    )
    settling_time: float = setting(
        15.0, "Time for the way to where exploration begins [s]", low=0.0, high=600.0
    )
    following_tolerance: float = setting(
        0.02, "Largest mean error of the lengths at which exploration may begin [m]", low=0.0
    )
    rest_distance: float = setting(
        0.001, "Motion of the tip over `rest_time` below which it is at rest [m]", low=0.0
    )
    rest_time: float = setting(3.0, "Time over which the tip must be at rest [s]", low=0.5)
    reach_timeout: float = setting(
        20.0, "Time after which a movement to a goal ends in any case [s]", low=0.5, high=3600.0
    )
    learn_in_use: str = setting(
        "offsets",
        "What movements to goals that others send teach: nothing, the offsets of the length "
        "sensors, or everything, as exploration does",
        choices=("nothing", "offsets", "everything"),
    )
    use_step: float = setting(
        0.01, "Motion of the tip between two examples of a robot in use [m]", low=1e-3
    )
    seed: int = setting(0, "Seed of the exploration", low=0)

    def __post_init__(self) -> None:
        check_settings(self)
