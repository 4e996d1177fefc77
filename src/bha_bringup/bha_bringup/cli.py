"""The command `bha`: a demonstration in one go, or a graph that stays up."""

from __future__ import annotations

import signal
import sys
import time
from dataclasses import replace
from pathlib import Path
from types import FrameType
from typing import Annotated, Optional

import typer
from rich.console import Console

from bha_bringup import driver_cli, running_cli, terminal_cli
from bha_bringup.demo import run_demo
from bha_bringup.demo_record import DemoRecord
from bha_bringup.demo_settings import DemoSettings
from bha_bringup.graph import HARDWARE, ROBOTS, SIM, GraphSettings, describe_graph
from bha_bringup.graph_lock import owning_graph
from bha_bringup.graph_processes import GraphError, GraphProcesses
from bha_bringup.report import error_table, write_report
from bha_bringup.robot_client import RobotClient
from bha_bringup.robot_connection import RobotError, refuse_second_graph
from bha_bringup.running_cli import MaybePath
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

Robot = Annotated[str, typer.Option(help=f"Which robot: {', '.join(ROBOTS)}.")]


@app.command()
def demo(
    space: Annotated[str, typer.Option(help="What is learned: 2d or 3d.")] = "2d",
    minutes: Annotated[
        Optional[float], typer.Option(help="Robot minutes of exploration; default: 30.")  # noqa: UP045
    ] = None,
    seed: Annotated[int, typer.Option(help="Draws the robot, noise and exploration.")] = 0,
    goals: Annotated[
        Optional[int], typer.Option(help="Held-out goals to reach; default: 25.")  # noqa: UP045
    ] = None,
    out: Annotated[MaybePath, typer.Option(help="Folder for report and models.")] = None,
    quick: Annotated[
        bool, typer.Option(help="A short look: 5 minutes and 5 goals, if not told otherwise.")
    ] = False,
    robot: Annotated[
        str, typer.Option(help="Which robot: sim, or hardware-emulated (in real time).")
    ] = "sim",
) -> None:
    """Start the graph, learn, reach held-out goals, and leave a report."""
    suffix = "" if robot == SIM else f"_{robot}"
    folder = (out or Path("results", f"demo_{space}_seed{seed}{suffix}")).expanduser()
    settings = DemoSettings(space=space, seed=seed, out=folder, robot=robot)
    if quick:
        settings = replace(settings, minutes=5.0, goals=5, identification_samples=20)
    if minutes is not None:
        settings = replace(settings, minutes=minutes)
    if goals is not None:
        settings = replace(settings, goals=goals)
    kind = "A simulated BHA" if robot == SIM else "A simulated BHA behind an emulated terminal"
    console.print(
        f"{kind} (robot {seed}) learns to reach, task {space}, from nothing: "
        f"{settings.minutes:g} robot minutes.\nEverything goes to {folder}; Ctrl-C ends it, "
        "and keeps what was learned."
    )
    record = DemoRecord(settings)
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
    models = models.expanduser().absolute()
    settings = GraphSettings(
        robot=robot,
        space=space,
        feedback=feedback,
        real_time_factor=real_time_factor,
        seed=seed,
        models=models,
        terminal=None if terminal is None else terminal.expanduser().absolute(),
    )
    if params_file is not None:
        params_file = params_file.expanduser()
        if not params_file.is_file():
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


# After `up`, so that `--help` tells the commands in the order in which they are used.
app.registered_commands += running_cli.app.registered_commands


def _tell_files(folder: Path, page: Path) -> None:
    console.print(f"\nreport   {page}\nresults  {folder / 'results.json'}")
    for path in sorted(folder.glob("*.png")):
        console.print(f"figure   {path}")
    console.print(f"models   {folder / 'models'}")


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
    except (RobotError, GraphError, DriverError, ValueError, OSError) as error:
        console.print(f"error: {error}", style="bold red", markup=False)
        sys.exit(1)


if __name__ == "__main__":
    main()
