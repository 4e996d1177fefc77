"""The commands `bha driver`: its life cycle and its stop, for hosts without `ros2`."""

from __future__ import annotations

from typing import Annotated

import numpy as np
import typer
from rich.console import Console

from bha_bringup.robot_client import RobotClient
from bha_common import bellows

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
def press(
    name: Annotated[str, typer.Argument(help="Which bellows, such as bellows_1_1.")],
    pressure: Annotated[float, typer.Argument(help="Gauge pressure in Pa.")] = 1e4,
    seconds: Annotated[float, typer.Option(help="For how long; then it vents by itself.")] = 3.0,
) -> None:
    """Press one bellows by hand; for a driver that was started alone."""
    if name not in bellows.NAMES:
        raise ValueError(f"{name} is no bellows; there are {', '.join(bellows.NAMES)}")
    index = bellows.NAMES.index(name)
    pressures = np.zeros(bellows.COUNT)
    pressures[index] = pressure
    with RobotClient() as robot:
        console.print(f"{name}: {pressure:g} Pa for {seconds:g} s")
        lengths = robot.press(pressures, seconds)
    console.print(f"{name} is {lengths[index]:.4f} m long")


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
