"""Which nodes make up the graph, with which parameters: one description for all who start it."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bha_driver.terminal_file import load_terminal
from bha_goal_babbling.task import find_task

NAMESPACE = "/bha"
SIM, HARDWARE, EMULATED = ROBOTS = ("sim", "hardware", "hardware-emulated")
MODEL_FILES = {"pressure_ctrl": "equilibrium_model.npz", "learner": "inverse_model.npz"}
"""Where each node that learns keeps its model, in the folder of the models."""
_EMULATOR_PORTS = 15020


@dataclass(frozen=True)
class NodeDescription:
    """One node to start.

    Attributes
    ----------
    package, executable : What to run; the node has the name of its executable.
    parameters : Its parameters by name.
    in_loop : Whether it is on the control loop that lockstep waits for at every control period;
        None where there is no lockstep.
    """

    package: str
    executable: str
    parameters: dict[str, Any] = field(default_factory=dict)
    in_loop: bool | None = None


@dataclass(frozen=True)
class GraphSettings:
    """What can be chosen about the graph.

    Attributes
    ----------
    robot : Which robot; one of `ROBOTS`: simulated, on the pneumatics, or simulated behind a
        terminal that is driven like that of the pneumatics.
    space : Task of the learner: ``2d``, ``3d``, or the path of a task file.
    feedback : Whether Cartesian feedback is part of the graph.
    real_time_factor : Simulated over wall time; 0 is lockstep, as fast as possible.
    seed : Draws the robot, its noise and the exploration.
    models : Folder for the models; None keeps none.
    start_paused : Whether the simulator waits for `~/pause` with false.
    terminal : Terminal map of the pneumatics; None for the emulated one.
    """

    robot: str = "sim"
    space: str = "2d"
    feedback: bool = True
    real_time_factor: float = 1.0
    seed: int = 0
    models: Path | None = None
    start_paused: bool = False
    terminal: Path | None = None

    def __post_init__(self) -> None:
        if self.robot not in ROBOTS:
            raise ValueError(f"robot is {self.robot!r}; valid are {', '.join(ROBOTS)}")
        if self.robot == HARDWARE and self.terminal is None:
            raise ValueError("robot is 'hardware': name its terminal map, such as my_lab.yaml")
        if self.robot == SIM and self.terminal is not None:
            raise ValueError("the simulator has no terminal; choose robot hardware")
        if self.robot != SIM and self.real_time_factor != 1.0:
            raise ValueError(
                f"real_time_factor is {self.real_time_factor:g}; {self.robot!r} lives in "
                "real time, 1"
            )
        if not 0.0 <= self.real_time_factor < float("inf"):
            raise ValueError(f"real_time_factor must be 0 or above, got {self.real_time_factor}")


def describe_graph(settings: GraphSettings) -> list[NodeDescription]:
    """Tell which nodes to start, in the order of starting.

    Raises
    ------
    InvalidTaskError
        When feedback is wanted for a task file that cannot be used.
    TerminalMapError
        When the terminal map cannot be used.
    """
    models = settings.models
    simulated = settings.robot == SIM
    name = f"bha_sim_{settings.seed}"
    if settings.robot == HARDWARE:
        name = load_terminal(settings.terminal).name

    def file(node: str) -> str:
        return "" if models is None else str(models / MODEL_FILES[node])

    nodes = [
        *_robot(settings),
        NodeDescription(
            "bha_pressure_ctrl",
            "pressure_ctrl",
            {
                "robot": name,
                "seed": settings.seed,
                "lockstep": settings.real_time_factor == 0.0,
                "model_file": file("pressure_ctrl"),
            },
            in_loop=True if simulated else None,
        ),
        NodeDescription(
            "bha_goal_babbling",
            "learner",
            {
                "robot": name,
                "seed": settings.seed,
                "task": settings.space,
                "model_file": file("learner"),
            },
            in_loop=False if simulated else None,
        ),
    ]
    if settings.feedback:
        axes = find_task(settings.space).outcome_size
        nodes.append(
            NodeDescription(
                "bha_cartesian_feedback",
                "cartesian_feedback",
                {"axes": axes},
                in_loop=False if simulated else None,
            )
        )
    return nodes


def _robot(settings: GraphSettings) -> list[NodeDescription]:
    """Tell which nodes are the robot."""
    if settings.robot == SIM:
        simulator = {
            "robot_seed": settings.seed,
            "real_time_factor": float(settings.real_time_factor),
            "start_paused": settings.start_paused,
        }
        return [NodeDescription("bha_sim", "simulator", simulator, in_loop=True)]
    terminal = "" if settings.terminal is None else str(settings.terminal)
    if settings.robot == HARDWARE:
        # A person says when it may press: bha driver activate.
        parameters = {"terminal": terminal, "autostart": "configure"}
        return [NodeDescription("bha_driver", "driver", parameters)]
    # A port a ROS domain, so that graphs beside one another do not meet.
    port = _EMULATOR_PORTS + int(os.environ.get("ROS_DOMAIN_ID") or 0)
    emulator: dict[str, Any] = {"terminal": terminal, "port": port, "robot_seed": settings.seed}
    driver = {
        "terminal": terminal,
        "host": "127.0.0.1",
        "port": port,
        "autostart": "activate",
    }
    return [
        NodeDescription("bha_bringup", "terminal_emulator", emulator),
        NodeDescription("bha_driver", "driver", driver),
    ]
