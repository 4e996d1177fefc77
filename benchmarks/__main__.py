"""The command `./bha paper`: the article's tables, made anew."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Any, Optional

import typer
from rich import box
from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from benchmarks.engine.execution import OtherCodeError
from benchmarks.engine.experiment import Experiment
from benchmarks.engine.rendering import bound_rows, columns, shown
from benchmarks.engine.report import ReportError, write_report
from benchmarks.engine.results import Order, Result, make_table
from benchmarks.tables import NAMES, UnknownTableError, find

app = typer.Typer(add_completion=False, context_settings={"help_option_names": ["-h", "--help"]})
console = Console(highlight=False)

# Ubuntu 24.04's typer, 0.9, knows no `int | None`.
MaybeInt = Optional[int]  # noqa: UP045
MaybeText = Optional[str]  # noqa: UP045


@app.command()
def paper(
    name: Annotated[
        str, typer.Argument(help="A table; `list` tells which there are; `all`; or `report`.")
    ],
    seeds: Annotated[
        MaybeInt, typer.Option(min=1, help="How many seeds; each has its own.")
    ] = None,
    first_seed: Annotated[
        int, typer.Option(min=0, help="0 to 99 are for tuning, 1000 and up for reporting.")
    ] = 1000,
    jobs: Annotated[int, typer.Option(min=1, help="Runs at once; every core by default.")] = (
        os.cpu_count() or 1
    ),
    scheduler: Annotated[
        MaybeText, typer.Option(help="Address of a Dask scheduler to send the runs to.")
    ] = None,
    quick: Annotated[bool, typer.Option(help="A short look at whether it works.")] = False,
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("results"),
) -> None:
    """Make a table of the article: NAME.json and NAME.png, and the claim beside what came out.

    A table that was interrupted goes on where it stopped. `report` writes the results that there
    are into docs/results.md; other tables stay there as they are. The exit status is 1 when a bound
    is missed.
    """
    if name == "list":
        console.print(_list_of_tables())
        return
    if name == "report":
        page = write_report(out, Path(__file__).parents[1] / "docs", NAMES)
        console.print(f"report   {page}")
        return
    order = Order(seeds, first_seed, quick, jobs, scheduler, out)
    chosen = [find(each) for each in (NAMES if name == "all" else [name])]
    missed = []
    for experiment in chosen:
        try:
            result = _make(experiment, order)
        except KeyboardInterrupt:
            console.print("\ninterrupted; the runs that ended are kept: the same command goes on")
            raise typer.Exit(130) from None
        _tell(experiment, result, out)
        missed += [f"{experiment.name}: {bound.what} {bound.bound}" for bound in result.missed]
    if missed:
        console.print("bounds missed:\n  " + "\n  ".join(missed), style="bold red", markup=False)
        raise typer.Exit(1)


def _make(experiment: Experiment, order: Order) -> Result:
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("runs"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=console,
        transient=True,
    ) as progress:
        task = progress.add_task(experiment.name, total=None)
        return make_table(
            experiment,
            order,
            lambda done, total: progress.update(task, completed=done, total=total),
        )


def _tell(experiment: Experiment, result: Result, out: Path) -> None:
    console.print(f"\n[bold]{experiment.name}[/bold]: {escape(experiment.shows)}")
    console.print(f"The article: {escape(experiment.claim)}\n")
    console.print(_table(result.content["rows"]))
    if result.content["bounds"]:
        console.print(_table(bound_rows(result.content["bounds"])))
    if result.summary.note:
        console.print(escape(result.summary.note))
    console.print(f"\nresults  {out / experiment.name}.json\nfigure   {result.figure}")


def _table(rows: list[dict[str, Any]]) -> Table:
    table = Table(box=box.SIMPLE_HEAD)
    heads = columns(rows)
    for head in heads:
        numeric = all(isinstance(row.get(head), int | float | None) for row in rows)
        table.add_column(escape(head), justify="right" if numeric else "left")
    for row in rows:
        table.add_row(*(escape(shown(row.get(head))) for head in heads))
    return table


def _list_of_tables() -> Table:
    return _table(
        [
            {
                "table": experiment.name,
                "shows": experiment.shows,
                "seeds": experiment.seeds,
                "minutes on two cores": experiment.minutes,
            }
            for experiment in map(find, NAMES)
        ]
    )


def main() -> None:
    """Run the command line; mistakes are told without a traceback."""
    try:
        app(prog_name="./bha paper")
    except (UnknownTableError, OtherCodeError, ReportError, OSError) as error:
        console.print(f"error: {error}", style="bold red", markup=False)
        sys.exit(2)


if __name__ == "__main__":
    main()
