"""The report of a demonstration: a table for the terminal and a page with the figures."""

from __future__ import annotations

import json
from pathlib import Path

from rich.table import Table

from bha_bringup.demo_record import DemoRecord, statistics
from bha_bringup.figures import write_figures
from bha_common.files import atomic_write

_KINDS = (("feedforward", "feed-forward"), ("feedback", "with Cartesian feedback"))
_CAPTIONS = {
    "learning_curve": "Error over exploration time",
    "goals": "Held-out goals and where the tip came to",
    "reach": "Lengths, pressures and error over one feed-forward movement",
}


def write_report(record: DemoRecord, folder: Path) -> Path:
    """Write figures and ``report.md`` into a folder; the path of the page."""
    figures = write_figures(record, folder)
    lines = [
        f"# Goal babbling on the simulated BHA: task {record.settings.space}, "
        f"robot {record.settings.seed}",
        "",
        f"{record.exploration_minutes:.1f} robot minutes of exploration: {record.movements} "
        f"movements, {record.samples} samples, {record.local_models} local maps, "
        f"{record.real_time_factor:.1f} times real time.",
        "",
        "| held-out goals | mean [mm] | median [mm] | 95 % [mm] |",
        "|---|---|---|---|",
        *(f"| {name} | {' | '.join(cells)} |" for name, *cells in error_rows(record)),
        "",
        f"Errors count {', '.join(record.axes)}.",
        "",
    ]
    for path in figures:
        lines += [f"![{_CAPTIONS[path.stem]}]({path.name})", "", f"*{_CAPTIONS[path.stem]}*", ""]
    lines += ["Versions: " + json.dumps(record.as_json()["versions"]), ""]
    page = folder / "report.md"
    atomic_write(page, "\n".join(lines).encode())
    return page


def error_rows(record: DemoRecord) -> list[list[str]]:
    """Name, mean, median and 95th percentile [mm] for each kind of control."""
    rows = []
    for kind, name in _KINDS:
        values = statistics(record.errors(kind)).values()
        rows.append([name, *("-" if value is None else f"{value * 1e3:.1f}" for value in values)])
    return rows


def error_table(record: DemoRecord) -> Table:
    """Make the table for the terminal."""
    table = Table(title=f"{len(record.goals)} held-out goals, distance to the goal [mm]")
    table.add_column("")
    for name in ("mean", "median", "95 %"):
        table.add_column(name, justify="right")
    for row in error_rows(record):
        table.add_row(*row)
    return table
