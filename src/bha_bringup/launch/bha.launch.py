"""Starts the graph: ros2 launch bha_bringup bha.launch.py [ARGUMENT:=VALUE ...]."""

from pathlib import Path

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from bha_bringup.graph import NAMESPACE, ROBOTS, GraphSettings, describe_graph
from launch import LaunchContext, LaunchDescription

ARGUMENTS = {
    "robot": ("sim", f"which robot: {', '.join(ROBOTS)}", ROBOTS),
    "space": ("2d", "what is learned: 2d, 3d, or the path of a task file", None),
    "feedback": ("true", "whether Cartesian feedback is part of the graph", ("true", "false")),
    "real_time_factor": ("1.0", "simulated over wall time; 0 is lockstep", None),
    "seed": ("0", "draws the simulated robot, its noise and the exploration", None),
    "terminal": ("", "terminal map of the pneumatics, for robot:=hardware", None),
    "models": ("", "folder where models are loaded from and saved to; empty: none", None),
    "params_file": ("", "YAML with parameters of the nodes, which go before all others", None),
}


def start(context: LaunchContext) -> list[Node]:
    """Make the nodes from the arguments."""
    value = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    settings = GraphSettings(
        robot=value["robot"],
        space=value["space"],
        feedback=value["feedback"] == "true",
        real_time_factor=float(value["real_time_factor"]),
        seed=int(value["seed"]),
        terminal=Path(value["terminal"]).expanduser() if value["terminal"] else None,
        models=Path(value["models"]).expanduser() if value["models"] else None,
    )
    files = [value["params_file"]] if value["params_file"] else []
    return [
        Node(
            package=node.package,
            executable=node.executable,
            namespace=NAMESPACE,
            parameters=[node.parameters, *files],
            output="screen",
        )
        for node in describe_graph(settings)
    ]


def generate_launch_description() -> LaunchDescription:
    """Describe the launch."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text)
        if choices is None
        else DeclareLaunchArgument(name, default_value=default, description=text, choices=choices)
        for name, (default, text, choices) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=start)])
