"""docs/results.md: every table that was made, beside what the article claims."""

import json
import shutil
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from benchmarks.rendering import bound_rows, columns, shown
from benchmarks.tables import NAMES
from bha_common.files import atomic_write

_HEAD = """# The article's tables, made anew

Each table stands beside what the article claims (Rolf and Steil, "Learning inverse models in high
dimensions with goal babbling and reward-weighted averaging"). `./bha paper NAME` makes one,
`./bha paper list` tells what there is and how long it takes, and `./bha paper report` writes this
page from the results. No setting was chosen on the seeds that a table names.
"""


class ReportError(ValueError):
    """There is nothing to write a page of."""


def write_report(results: Path, docs: Path) -> Path:
    """Write the page of all tables in a folder, and copy their figures beside it.

    Parameters
    ----------
    results : Path
        Folder with NAME.json and NAME.png of the tables.
    docs : Path
        Folder of the page `results.md`; figures go to `images/`.

    Raises
    ------
    ReportError
        If there is no table, or one was made in quick runs, which tell nothing.
    """
    names = [name for name in NAMES if (results / f"{name}.json").is_file()]
    tables = [json.loads((results / f"{name}.json").read_text(encoding="utf-8")) for name in names]
    quick = [table["name"] for table in tables if table["quick"]]
    if not tables or quick:
        raise ReportError(
            f"{results}: {', '.join(quick)} came of --quick; make it in full first"
            if quick
            else f"{results}: there is no table yet; make some with `./bha paper NAME`"
        )
    for name in names:
        (docs / "images").mkdir(parents=True, exist_ok=True)
        shutil.copyfile(results / f"{name}.png", docs / "images" / f"paper_{name}.png")
    page = docs / "results.md"
    atomic_write(page, results_page(tables).encode())
    return page


def results_page(tables: Sequence[dict[str, Any]]) -> str:
    """Return the page of some tables, each the content of its JSON."""
    overview = [
        {
            "table": f"[{table['name']}](#{table['name']})",
            "shows": table["shows"],
            "bounds": _bounds_kept(table["bounds"]),
        }
        for table in tables
    ]
    return "\n".join([_HEAD, _markdown(overview), *map(_section, tables)])


def _section(table: dict[str, Any]) -> str:
    name, seeds = table["name"], table["seeds"]
    parts = [
        f"## {name}",
        f"The article: {table['claim']}",
        f"Ours: {table['shows']}.",
        _markdown(table["rows"]),
        *([_markdown(bound_rows(table["bounds"]))] if table["bounds"] else []),
        *([table["note"]] if table["note"] else []),
        f"![{table['shows']}](images/paper_{name}.png)",
        f"`{table['command']}`, {table['date']}, seeds {seeds[0]} to {seeds[-1]}, "
        f"numpy {table['versions']['numpy']}.",
    ]
    return "\n" + "\n\n".join(part.rstrip("\n") for part in parts) + "\n"


def _bounds_kept(bounds: Sequence[dict[str, Any]]) -> str:
    kept = sum(bound["holds"] for bound in bounds)
    return f"{kept} of {len(bounds)} hold" if bounds else "none set"


def _markdown(rows: Sequence[dict[str, Any]]) -> str:
    heads = columns(list(rows))
    lines = [heads, ["---"] * len(heads)]
    lines += [[shown(row.get(head)) for head in heads] for row in rows]
    return "\n".join(_line(cells) for cells in lines) + "\n"


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
