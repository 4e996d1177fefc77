"""The commands `bha terminal`: look at a lab's terminal, and calibrate its potentiometers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Optional

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from bha_common import bellows
from bha_common.files import atomic_write
from bha_driver.calibration import scale_and_offset, with_calibration
from bha_driver.terminal_check import Survey, survey
from bha_driver.terminal_file import load_terminal
from bha_driver.terminal_map import TerminalMap

app = typer.Typer(help="Look at the terminal of the pneumatics.", no_args_is_help=True)
console = Console(highlight=False)

File = Annotated[Path, typer.Argument(help="The terminal map, such as my_lab.yaml.")]


@app.command()
def check(file: File) -> None:
    """Read the terminal for a second and show what it measures; nothing is ever written to it."""
    terminal = load_terminal(file)
    console.print(f"{file}: a good terminal map; asking {terminal.host}:{terminal.port} ...")
    found = survey(terminal)
    console.print(_table(found))
    watchdog = "not in the map" if found.watchdog is None else f"holds {found.watchdog}"
    console.print(
        f"a read takes {found.round_trip * 1e3:.1f} ms, "
        f"at most {found.longest_round_trip * 1e3:.1f} ms; watchdog register: {watchdog}"
    )
    for problem in found.problems:
        console.print(f"problem: {problem}", style="bold red", markup=False)
    if found.problems:
        raise typer.Exit(1)
    console.print("no problem seen; nothing was written to the terminal")


@app.command()
def calibrate(
    file: File,
    only: Annotated[
        Optional[list[str]],  # noqa: UP045  Ubuntu 24.04's typer knows no `list[str] | None`
        typer.Option("--only", help="This bellows alone, such as bellows_1_1; may be repeated."),
    ] = None,
) -> None:
    """Measure zero and span of each potentiometer, and write them into the terminal map."""
    terminal = load_terminal(file)
    names = list(only or bellows.NAMES)
    for name in names:
        if name not in bellows.NAMES:
            raise ValueError(f"{name} is no bellows; there are {', '.join(bellows.NAMES)}")
    console.print(
        "The air must be off and the robot vented. For each bellows hold it at two lengths, near "
        "the shortest and\nnear the longest, and measure each from flange to flange. "
        "An empty answer leaves a bellows out; Ctrl-C ends it,\nand what was written so far stays."
    )
    for name in names:
        points = _two_points(terminal, name)
        if points is None:
            console.print(f"{name}: left as it is")
            continue
        scale, offset = scale_and_offset(*points)
        text = with_calibration(file.read_text(encoding="utf-8"), name, scale, offset)
        atomic_write(file, text.encode())
        console.print(f"{name}: scale {scale:.4e} m a count, offset {offset:.4f} m; written")


def _two_points(
    terminal: TerminalMap, name: str
) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Ask for two lengths; the raw values there and the lengths [m], or None for none."""
    while True:
        raw, lengths = [], []
        for kind in ("short", "long"):
            answer = typer.prompt(f"{name}, {kind}: length in mm", default="", show_default=False)
            if not answer.strip():
                return None
            try:
                lengths.append(float(answer) * 1e-3)
            except ValueError:
                console.print(f"{answer!r} is no number; write for example 152.5")
                break
            raw.append(float(survey(terminal).raw[bellows.NAMES.index(name)]))
            console.print(f"  raw value {raw[-1]:.1f}")
        if len(raw) < 2:
            continue
        points = (raw[0], raw[1]), (lengths[0], lengths[1])
        try:
            scale_and_offset(*points)
        except ValueError as error:
            console.print(f"{error}; once more")
            continue
        return points


def _table(found: Survey) -> Table:
    table = Table()
    for title in ("bellows", "raw", "length", "noise", "pressure"):
        table.add_column(escape(title), justify="left" if title == "bellows" else "right")
    for index, name in enumerate(bellows.NAMES):
        table.add_row(
            name,
            f"{found.raw[index]:.0f}",
            f"{found.lengths[index]:.4f} m",
            f"{found.length_noise[index] * 1e3:.2f} mm",
            f"{found.pressures[index]:.0f} Pa",
        )
    return table
