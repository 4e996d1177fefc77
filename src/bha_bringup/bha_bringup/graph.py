"""Which nodes make up the graph, with which parameters: one description for all who start it."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bha_goal_babbling.task import find_task

NAMESPACE = "/bha"
ROBOTS = ("sim",)


@dataclass(frozen=True)
class NodeDescription:
    """One node to start.

    Attributes
    ----------
    package, executable : What to run; the node has the name of its executable.
    parameters : Its parameters by name.
    in_loop : Whether it is on the control loop that lockstep waits for at every control period.
    """

    package: str
    executable: str
    parameters: dict[str, Any] = field(default_factory=dict)
    in_loop: bool = False


@dataclass(frozen=True)
class GraphSettings:
    """What can be chosen about the graph.

    Attributes
    ----------
    robot : Which robot; one of `ROBOTS`.
    space : Task of the learner: ``2d``, ``3d``, or the path of a task file.
    feedback : Whether Cartesian feedback is part of the graph.
    real_time_factor : Simulated over wall time; 0 is lockstep, as fast as possible.
    seed : Draws the robot, its noise and the exploration.
    models : Folder for the models; None keeps none.
    start_paused : Whether the simulator waits for `~/pause` with false.
    """

    robot: str = "sim"
    space: str = "2d"
    feedback: bool = True
    real_time_factor: float = 1.0
    seed: int = 0
    models: Path | None = None
    start_paused: bool = False

    def __post_init__(self) -> None:
        if self.robot not in ROBOTS:
            raise ValueError(f"robot is {self.robot!r}; valid are {', '.join(ROBOTS)}")
        if not 0.0 <= self.real_time_factor < float("inf"):
            raise ValueError(f"real_time_factor must be 0 or above, got {self.real_time_factor}")


def describe_graph(settings: GraphSettings) -> list[NodeDescription]:
    """Tell which nodes to start, in the order of starting.

    Raises
    ------
    InvalidTaskError
        When feedback is wanted for a task file that cannot be used.
    """
    models = settings.models
    name = f"bha_sim_{settings.seed}" if settings.robot == "sim" else "bha"

    def file(stem: str) -> str:
        return "" if models is None else str(models / f"{stem}.npz")

    nodes = [
        NodeDescription(
            "bha_sim",
            "simulator",
            {
                "robot_seed": settings.seed,
                "real_time_factor": float(settings.real_time_factor),
                "start_paused": settings.start_paused,
            },
            in_loop=True,
        ),
        NodeDescription(
            "bha_pressure_ctrl",
            "pressure_ctrl",
            {
                "robot": name,
                "seed": settings.seed,
                "lockstep": settings.real_time_factor == 0.0,
                "model_file": file("equilibrium_model"),
            },
            in_loop=True,
        ),
        NodeDescription(
            "bha_goal_babbling",
            "learner",
            {
                "robot": name,
                "seed": settings.seed,
                "task": settings.space,
                "model_file": file("inverse_model"),
            },
        ),
    ]
    if settings.feedback:
        axes = find_task(settings.space).outcome_size
        nodes.append(
            NodeDescription("bha_cartesian_feedback", "cartesian_feedback", {"axes": axes})
        )
    return nodes
