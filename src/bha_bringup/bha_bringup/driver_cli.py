"""The commands `bha driver`: its life cycle and its stop, for hosts without `ros2`."""

from __future__ import annotations

import typer
from rich.console import Console

from bha_bringup.robot_client import RobotClient

app = typer.Typer(help="Let the driver of the pneumatics press, or not.", no_args_is_help=True)
console = Console(highlight=False)


@app.command()
def configure() -> None:
    """Connect to the terminal and read it; nothing is driven."""
    _change("configure")


@app.command()
def activate() -> None:
    """Allow pressing: from now on commands move the robot."""
    _change("activate")


@app.command()
def deactivate() -> None:
    """Vent, and drive nothing."""
    _change("deactivate")


@app.command()
def cleanup() -> None:
    """Vent and disconnect."""
    _change("cleanup")


@app.command()
def stop() -> None:
    """Press the emergency stop of the graph: the latched safe state."""
    with RobotClient() as robot:
        console.print(robot.emergency_stop())


@app.command()
def reset() -> None:
    """End an emergency stop or a fault, when its cause is gone."""
    with RobotClient() as robot:
        console.print(robot.emergency_stop_reset())


def _change(transition: str) -> None:
    with RobotClient() as robot:
        console.print(f"the driver is {robot.change_driver(transition)}")
