"""Settings of the simulator: which robot, and how often it is seen."""

from __future__ import annotations

from dataclasses import dataclass

from bha_common.settings import check_settings, setting


@dataclass(frozen=True)
class SimulatorSettings:
    """Which robot is simulated, and how often it is seen."""

    robot_file: str = setting("", "YAML of the robot's physics; empty: the one of this package")
    robot_seed: int = setting(0, "Draws the individual robot and the noise of its sensors", low=0)
    control_period: float = setting(
        0.02, "Time between two states [s]; a multiple of the integration step", low=1e-3, high=1.0
    )
    tip_period: float = setting(
        0.1,
        "Time between two of tip, pressures and /clock [s]; multiple of the control period",
        low=1e-3,
    )
    max_command_age: float = setting(
        0.5, "Age at which a pressure command is dropped [s]", low=0.02
    )
    start_paused: bool = setting(False, "Wait for `~/pause` with false before the first state")

    def __post_init__(self) -> None:
        check_settings(self)
