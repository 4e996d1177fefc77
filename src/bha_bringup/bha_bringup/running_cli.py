"""The commands of `bha` for a graph that is up: teach it, use it, look at it, end it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Optional

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from bha_bringup.disturbing import as_parameters, read_disturbances
from bha_bringup.graph import MODEL_FILES
from bha_bringup.graph_lock import stop_owner
from bha_bringup.model_transfer import adopt_models
from bha_bringup.robot_client import CONTROLLER, LEARNER, SIMULATOR, RobotClient
from bha_bringup.robot_connection import RobotError

app = typer.Typer()
console = Console(highlight=False)

# Ubuntu 24.04's typer, 0.9, knows no `Path | None`.
MaybePath = Optional[Path]  # noqa: UP045
Point = Annotated[float, typer.Argument(help="Coordinate in bha_base, in m.")]
Feedback = Annotated[bool, typer.Option(help="Use Cartesian feedback: exact, but slow.")]


@app.command()
def identify(
    samples: Annotated[int, typer.Argument(help="Settled postures; 0: the default.")] = 0,
) -> None:
    """Let the pressure controller learn which pressures hold which lengths."""
    with RobotClient() as robot:
        with _Line() as tell:
            result = robot.identify(
                samples,
                lambda seen: tell(
                    f"{seen.collected}/{seen.requested} postures, {seen.elapsed:.0f} s"
                ),
            )
        console.print(result.message)
        _keep(robot, CONTROLLER)


@app.command()
def babble(
    minutes: Annotated[float, typer.Argument(help="Robot minutes.")] = 30.0,
    restart: Annotated[bool, typer.Option(help="Forget what was learned before.")] = False,
) -> None:
    """Explore and learn; Ctrl-C ends it and keeps what was learned."""
    with RobotClient() as robot:
        with _Line() as tell:
            result = robot.babble(
                minutes * 60.0,
                restart=restart,
                progress=lambda seen: tell(
                    f"{seen.elapsed / 60:.1f}/{minutes:g} min, {seen.status.movements} movements, "
                    f"recent error {seen.status.recent_error * 1e3:.0f} mm"
                ),
            )
        console.print(result.message)
        _keep(robot, LEARNER)


@app.command(context_settings={"ignore_unknown_options": True})
def goal(x: Point, y: Point, z: Point, feedback: Feedback = False) -> None:
    """Set a goal and come back at once."""
    with RobotClient() as robot:
        console.print(robot.set_goal(np.array([x, y, z]), feedback=feedback))


@app.command(context_settings={"ignore_unknown_options": True})
def reach(x: Point, y: Point, z: Point, feedback: Feedback = False) -> None:
    """Go to a goal and wait until the tip is at rest; exit with 1 when that takes too long."""
    with RobotClient() as robot, _Line() as tell:
        result = robot.reach(
            np.array([x, y, z]),
            feedback=feedback,
            progress=lambda seen: tell(f"{seen.error * 1e3:6.1f} mm, {seen.elapsed:.1f} s"),
        )
    tip = ", ".join(f"{value:.4f}" for value in result.tip)
    console.print(
        f"{result.message} after {result.duration:.1f} s: tip at {tip} m, "
        f"{result.error * 1e3:.1f} mm from the goal"
    )
    if not result.success:
        raise typer.Exit(1)


@app.command()
def disturb(
    what: Annotated[
        Optional[list[str]],  # noqa: UP045
        typer.Argument(help="payload=0.2, leak.bellows_2_1=0.3, ...; nothing: all is sound."),
    ] = None,
) -> None:
    """Let something go wrong with the simulated robot, instead of what was wrong before."""
    try:
        disturbances = read_disturbances(what or [])
    except ValueError as error:
        raise typer.BadParameter(str(error)) from None
    with RobotClient() as robot:
        robot.set_parameters(SIMULATOR, as_parameters(disturbances))
    console.print(f"disturbances: {disturbances}", markup=False)


@app.command()
def status() -> None:
    """Show what every node says of itself."""
    with RobotClient() as robot:
        if not robot.wait(lambda: bool(robot.nodes()), timeout=5.0):
            raise RobotError("there is no graph in this ROS domain: start one with bha up")
        # Each node speaks once a second: after two, who is silent has nothing to say.
        robot.wait(lambda: False, timeout=2.2)
        names = robot.nodes() | set(robot.diagnostics)
        table = Table()
        for title in ("node", "state", "details"):
            table.add_column(title)
        for name in sorted(names):
            said = robot.diagnostics.get(name)
            details = [f"{item.key}: {item.value}" for item in said.values] if said else []
            state = said.message if said else "silent"
            table.add_row(name, escape(state), escape("\n".join(details)))
    console.print(table)


@app.command()
def save(
    folder: Annotated[
        MaybePath, typer.Argument(help="Where to; default: where `up` keeps them.")
    ] = None,
) -> None:
    """Save the models of the controller and the learner."""
    _both_models(lambda robot, node, path: robot.save(node, path), folder)


@app.command()
def load(
    folder: Annotated[
        MaybePath, typer.Argument(help="Where from; default: where `up` keeps them.")
    ] = None,
) -> None:
    """Load models into the controller and the learner."""
    _both_models(lambda robot, node, path: robot.load(node, path), folder)


@app.command()
def adopt(
    source: Annotated[Path, typer.Argument(help="Folder of the models of one robot.")],
    target: Annotated[Path, typer.Argument(help="Folder for the copies.")],
    robot: Annotated[
        str, typer.Option(help="Name of the robot they are for, such as that of the terminal map.")
    ],
) -> None:
    """Copy models of one robot for another, as from the simulator to the pneumatics."""
    for path in adopt_models(source.expanduser(), target.expanduser(), robot):
        console.print(f"{path}: for robot {robot}")


@app.command()
def stop() -> None:
    """End the graph that `bha up` or `bha demo` has started in this ROS domain."""
    if not stop_owner():
        raise RobotError("there is no graph in this ROS domain that bha has started")
    console.print("stopped")


def _keep(robot: RobotClient, node: str) -> None:
    """Save what was learned; where that fails, as without a file, it was learned all the same."""
    try:
        robot.save(node)
    except RobotError as error:
        console.print(f"not saved ({error}): `bha save FOLDER` saves it", markup=False)


def _both_models(act: Callable[[RobotClient, str, str], str], folder: Path | None) -> None:
    with RobotClient() as robot:
        for node, name in MODEL_FILES.items():
            path = "" if folder is None else str(folder.expanduser().absolute() / name)
            console.print(f"{node}: {act(robot, node, path)}")


class _Line:
    """One line of the terminal that is written over and over."""

    def __enter__(self) -> Callable[[str], None]:
        self._status = console.status("waiting for the robot")
        self._status.start()
        return self._status.update

    def __exit__(self, *_: object) -> None:
        self._status.stop()
