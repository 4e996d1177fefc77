"""The text of docs/results.md: an overview, and a section for every table."""

import re
from collections.abc import Iterable, Sequence
from typing import Any

from benchmarks.engine.rendering import bound_rows, columns, shown

_HEAD = """# The article's tables, made anew

Each table stands beside what the article claims (Rolf and Steil, "Learning inverse models in high
dimensions with goal babbling and reward-weighted averaging"). `./bha paper NAME` makes one,
`./bha paper list` tells what there is and how long it takes, and `./bha paper report` writes this
page from the results. No setting was chosen on the seeds that a table names.
"""

_OVERVIEW = ("table", "shows", "bounds")
_OVERVIEW_ROW = r"^\| \[([\w-]+)\]\(#\1\) \|.*$"


def results_page(tables: Sequence[dict[str, Any]], order: Sequence[str], before: str = "") -> str:
    """Return the page with some tables made anew, and all others as they stood on it.

    Parameters
    ----------
    tables : sequence of dict
        Tables, each the content of its JSON.
    order : sequence of str
        Names of all tables, in the order of the page. What stood on it under another name goes.
    before : str
        The page so far, which holds tables that were made earlier or elsewhere.
    """
    rows = {row[1]: row[0] for row in re.finditer(_OVERVIEW_ROW, before, re.M)}
    sections = {text.partition("\n")[0]: text for text in _texts_of_sections(before)}
    for table in tables:
        rows[table["name"]] = _overview_row(table)
        sections[table["name"]] = _section(table)
    names = [name for name in order if name in sections]
    overview = [_line(_OVERVIEW), _line(["---"] * len(_OVERVIEW))]
    overview += [rows[name] for name in names if name in rows]
    return "\n".join([_HEAD, *overview, "", *(f"\n## {sections[name]}\n" for name in names)])


def _texts_of_sections(page: str) -> list[str]:
    return [text.rstrip("\n") for text in re.split(r"^## ", page, flags=re.M)[1:]]


def _overview_row(table: dict[str, Any]) -> str:
    name, bounds = table["name"], table["bounds"]
    kept = sum(bound["holds"] for bound in bounds)
    judged = f"{kept} of {len(bounds)} hold" if bounds else "none set"
    return _line([f"[{name}](#{name})", table["shows"], judged])


def _section(table: dict[str, Any]) -> str:
    """Return the section of a table, from its name on."""
    name, seeds = table["name"], table["seeds"]
    parts = [
        name,
        f"The article: {table['claim']}",
        f"Ours: {table['shows']}.",
        _markdown(table["rows"]),
        *([_markdown(bound_rows(table["bounds"]))] if table["bounds"] else []),
        *([table["note"]] if table["note"] else []),
        f"![{table['shows']}](images/paper_{name}.png)",
        f"`{table['command']}`, {table['date']}, seeds {seeds[0]} to {seeds[-1]}, "
        f"numpy {table['versions']['numpy']}.",
    ]
    return "\n\n".join(part.rstrip("\n") for part in parts)


def _markdown(rows: Sequence[dict[str, Any]]) -> str:
    heads = columns(list(rows))
    lines = [heads, ["---"] * len(heads)]
    lines += [[shown(row.get(head)) for head in heads] for row in rows]
    return "\n".join(_line(cells) for cells in lines)


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
