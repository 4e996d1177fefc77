"""The command `bha`: a demonstration in one go, or a graph step by step."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Annotated, Optional

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from bha_bringup import driver_cli, terminal_cli
from bha_bringup.demo import run_demo
from bha_bringup.demo_record import DemoRecord
from bha_bringup.demo_settings import DemoSettings
from bha_bringup.disturbing import as_parameters, read_disturbances
from bha_bringup.graph import HARDWARE, ROBOTS, SIM, GraphSettings, describe_graph
from bha_bringup.graph_lock import owning_graph, stop_owner
from bha_bringup.graph_processes import GraphError, GraphProcesses
from bha_bringup.model_transfer import adopt_models
from bha_bringup.report import error_table, write_report
from bha_bringup.robot_client import (
    CONTROLLER,
    LEARNER,
    SIMULATOR,
    RobotClient,
    RobotError,
    refuse_second_graph,
)
from bha_driver.errors import DriverError

app = typer.Typer(
    name="bha",
    help="Teach the Bionic Handling Assistant to reach.",
    no_args_is_help=True,
    add_completion=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.add_typer(terminal_cli.app, name="terminal")
app.add_typer(driver_cli.app, name="driver")
console = Console(highlight=False)

# Ubuntu 24.04's typer, 0.9, knows no `Path | None`.
MaybePath = Optional[Path]  # noqa: UP045
Point = Annotated[float, typer.Argument(help="Coordinate in bha_base [m].")]
Robot = Annotated[str, typer.Option(help=f"Which robot: {', '.join(ROBOTS)}.")]
Feedback = Annotated[bool, typer.Option(help="Use Cartesian feedback: exact, but slow.")]


@app.command()
def demo(
    space: Annotated[str, typer.Option(help="What is learned: 2d or 3d.")] = "2d",
    minutes: Annotated[float, typer.Option(help="Robot minutes of exploration.")] = 30.0,
    seed: Annotated[int, typer.Option(help="Draws the robot, noise and exploration.")] = 0,
    goals: Annotated[int, typer.Option(help="Held-out goals to reach.")] = 25,
    out: Annotated[MaybePath, typer.Option(help="Folder for report and models.")] = None,
    quick: Annotated[bool, typer.Option(help="A short look: 5 minutes, 5 goals.")] = False,
    robot: Annotated[
        str, typer.Option(help="Which robot: sim, or hardware-emulated (in real time).")
    ] = "sim",
) -> None:
    """Start the graph, learn, reach held-out goals, and leave a report."""
    suffix = "" if robot == SIM else f"_{robot}"
    folder = out or Path("results", f"demo_{space}_seed{seed}{suffix}")
    settings = DemoSettings(space, minutes, seed, goals, folder, robot=robot)
    if quick:
        settings = replace(settings, minutes=5.0, goals=5, identification_samples=20)
    kind = "A simulated BHA" if robot == SIM else "A simulated BHA behind an emulated terminal"
    console.print(
        f"{kind} (robot {seed}) learns to reach, task {space}, from nothing: "
        f"{settings.minutes:g} robot minutes.\nEverything goes to {folder}; Ctrl-C ends it, "
        "and keeps what was learned."
    )
    record = DemoRecord(settings)
    with owning_graph():
        run_demo(record, console)
    page = write_report(record, folder)
    console.print(error_table(record))
    _tell_files(folder, page)
    console.print(
        "\nWhat to do next:\n"
        f"  ./bha up --space {space} --seed {seed} --models {folder / 'models'}\n"
        "  ./bha reach 0.15 0.10 0.76            in another terminal; --feedback for more\n"
        "  ./bha shell                           to look at topics and services"
    )


@app.command()
def up(
    space: Annotated[str, typer.Option(help="2d, 3d, or the path of a task file.")] = "2d",
    robot: Robot = "sim",
    terminal: Annotated[
        MaybePath, typer.Option(help="Terminal map of the pneumatics, for --robot hardware.")
    ] = None,
    feedback: Annotated[bool, typer.Option(help="With Cartesian feedback.")] = True,
    real_time_factor: Annotated[
        float, typer.Option(help="Simulated over wall time; 0 is as fast as possible.")
    ] = 1.0,
    seed: Annotated[int, typer.Option(help="Draws the robot, noise and exploration.")] = 0,
    models: Annotated[Path, typer.Option(help="Folder of the models.")] = Path("models"),
    params_file: Annotated[MaybePath, typer.Option(help="YAML with parameters.")] = None,
) -> None:
    """Start the graph and keep it up until Ctrl-C or `bha stop`."""
    settings = GraphSettings(
        robot=robot,
        space=space,
        feedback=feedback,
        real_time_factor=real_time_factor,
        seed=seed,
        models=models.expanduser().absolute(),
        terminal=None if terminal is None else terminal.expanduser().absolute(),
    )
    if params_file is not None and not params_file.is_file():
        raise ValueError(f"{params_file}: there is no such file")
    refuse_second_graph()
    nodes = describe_graph(settings)
    with owning_graph(), GraphProcesses(nodes, models / "logs", params_file) as processes:
        with RobotClient(processes.check) as client:
            # A terminal may be off, or its driver wait for a person.
            client.wait_for_graph({node.executable for node in nodes}, chained=robot != HARDWARE)
            names = ", ".join(node.executable for node in nodes)
            console.print(f"up: {names}; logs in {models / 'logs'}; Ctrl-C or `bha stop` ends it")
            if robot == HARDWARE:
                console.print("the driver reads and drives nothing; `bha driver activate` lets it")
        while True:
            processes.check()
            time.sleep(0.2)


@app.command()
def identify(
    samples: Annotated[int, typer.Argument(help="Settled postures; 0: the default.")] = 0,
) -> None:
    """Let the pressure controller learn which pressures hold which lengths."""
    with RobotClient() as robot, _Line() as tell:
        result = robot.identify(
            samples,
            lambda seen: tell(f"{seen.collected}/{seen.requested} postures, {seen.elapsed:.0f} s"),
        )
        robot.save(CONTROLLER)
    console.print(result.message)


@app.command()
def babble(
    minutes: Annotated[float, typer.Argument(help="Robot minutes.")] = 30.0,
    restart: Annotated[bool, typer.Option(help="Forget what was learned before.")] = False,
) -> None:
    """Explore and learn; Ctrl-C ends it and keeps what was learned."""
    with RobotClient() as robot, _Line() as tell:
        result = robot.babble(
            minutes * 60.0,
            restart=restart,
            progress=lambda seen: tell(
                f"{seen.elapsed / 60:.1f}/{minutes:g} min, {seen.status.movements} movements, "
                f"recent error {seen.status.recent_error * 1e3:.0f} mm"
            ),
        )
        robot.save(LEARNER)
    console.print(result.message)


@app.command(context_settings={"ignore_unknown_options": True})
def goal(x: Point, y: Point, z: Point, feedback: Feedback = False) -> None:
    """Set a goal and come back at once."""
    with RobotClient() as robot:
        console.print(robot.set_goal(np.array([x, y, z]), feedback=feedback))


@app.command(context_settings={"ignore_unknown_options": True})
def reach(x: Point, y: Point, z: Point, feedback: Feedback = False) -> None:
    """Go to a goal and wait until the tip is at rest."""
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
        Path, typer.Argument(help="Where to; default: where `up` keeps them.")
    ] = Path(),
) -> None:
    """Save the models of the controller and the learner."""
    _both_models(lambda robot, node, path: robot.save(node, path), folder)


@app.command()
def load(
    folder: Annotated[
        Path, typer.Argument(help="Where from; default: where `up` keeps them.")
    ] = Path(),
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


def _both_models(act: Callable[[RobotClient, str, str], str], folder: Path) -> None:
    with RobotClient() as robot:
        for node, name in ((CONTROLLER, "equilibrium_model"), (LEARNER, "inverse_model")):
            path = "" if folder == Path() else str(folder.absolute() / f"{name}.npz")
            console.print(f"{node}: {act(robot, node, path)}")


def _tell_files(folder: Path, page: Path) -> None:
    console.print(f"\nreport   {page}\nresults  {folder / 'results.json'}")
    for path in sorted(folder.glob("*.png")):
        console.print(f"figure   {path}")
    console.print(f"models   {folder / 'models'}")


class _Line:
    """One line of the terminal that is written over and over."""

    def __enter__(self) -> Callable[[str], None]:
        self._status = console.status("waiting for the robot")
        self._status.start()
        return self._status.update

    def __exit__(self, *_: object) -> None:
        self._status.stop()


class Interrupted(BaseException):
    """The user or the system wants this process to end."""


def main() -> None:
    """Run the command line; mistakes and refusals are told without a traceback."""
    signals = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def interrupt(_: int, __: FrameType | None) -> None:
        for number in signals:  # the clean-up that follows must not be broken off
            signal.signal(number, signal.SIG_IGN)
        raise Interrupted

    for number in signals:
        signal.signal(number, interrupt)
    try:
        app(prog_name="bha")
    except Interrupted:
        console.print("\ninterrupted; what was learned is kept")
        sys.exit(130)
    except (RobotError, GraphError, DriverError, ValueError) as error:
        console.print(f"error: {error}", style="bold red", markup=False)
        sys.exit(1)


if __name__ == "__main__":
    main()
