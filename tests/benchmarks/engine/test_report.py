"""docs/results.md: what the tables hold is on it, and what was on it before stays."""

import json
from pathlib import Path
from typing import Any

import pytest

from benchmarks.engine.page import results_page
from benchmarks.engine.report import ReportError, write_report
from benchmarks.tables import NAMES

DOCS = Path(__file__).parents[3] / "docs"
ORDER = ("first", "second-table", "third")


def bound(measured: float) -> dict[str, Any]:
    """Return the bound that a number must not be above ten."""
    return {"what": "largest", "bound": "<= 10", "measured": measured, "holds": measured <= 10}


def content(name: str, largest: float = 4.0, *, quick: bool = False) -> dict[str, Any]:
    """Return the JSON of a table."""
    return {
        "name": name,
        "claim": f"{name} of the article",
        "shows": f"what {name} shows",
        "rows": [{"number": 300, "square [m]": 91000.0}, {"number": 1, "square [m]": largest}],
        "bounds": [bound(largest)],
        "note": f"a note on {name}",
        "seeds": [1000, 1001],
        "quick": quick,
        "command": f"./bha paper {name} --seeds 2",
        "date": "2026-01-02",
        "versions": {"numpy": "2.0.0"},
    }


def section(page: str, name: str) -> str:
    """Return the text of a table on a page, without the lines between it and the next."""
    return page.partition(f"\n## {name}\n")[2].partition("\n## ")[0].rstrip("\n")


def lay(folder: Path, *tables: dict[str, Any]) -> Path:
    """Lay the results of tables into a folder."""
    folder.mkdir()
    for table in tables:
        (folder / f"{table['name']}.json").write_text(json.dumps(table))
        (folder / f"{table['name']}.png").write_bytes(f"figure of {table['name']}".encode())
    return folder


def test_the_page_holds_what_the_tables_hold(tmp_path: Path) -> None:
    results = lay(tmp_path / "results", content("first", 91001.0))
    page = write_report(results, tmp_path / "docs", ORDER).read_text()
    assert "| [first](#first) | what first shows | 0 of 1 hold |" in page
    assert "| 300 | 91000 |" in page
    assert "| largest <= 10 | 91001 | MISSED |" in page
    assert "first of the article" in page
    assert "a note on first" in page
    assert "`./bha paper first --seeds 2`, 2026-01-02, seeds 1000 to 1001, numpy 2.0.0." in page
    figure = tmp_path / "docs" / "images" / "paper_first.png"
    assert figure.read_bytes() == b"figure of first"


def test_tables_without_a_result_stay_as_they_are(tmp_path: Path) -> None:
    """First and third are on the page and the second is made: the page has all three, in order."""
    docs = tmp_path / "docs"
    write_report(lay(tmp_path / "theirs", content("first"), content("third")), docs, ORDER)
    before = (docs / "results.md").read_text().replace("a note on first", "a note *by hand*")
    (docs / "results.md").write_text(before)
    write_report(lay(tmp_path / "ours", content("second-table")), docs, ORDER)
    after = (docs / "results.md").read_text()
    for name in ("first", "third"):
        assert section(after, name) == section(before, name)
        assert (docs / "images" / f"paper_{name}.png").is_file()
    assert "by hand" in section(after, "first")
    assert "a note on second-table" in section(after, "second-table")
    assert [line[3:] for line in after.splitlines() if line.startswith("## ")] == list(ORDER)
    rows = [line for line in after.splitlines() if line.startswith("| [")]
    assert rows == [f"| [{name}](#{name}) | what {name} shows | 1 of 1 hold |" for name in ORDER]


def test_a_table_that_is_made_again_takes_its_own_place(tmp_path: Path) -> None:
    before = results_page([content("first"), content("third")], ORDER)
    after = results_page([content("first", 20.0)], ORDER, before)
    assert "| [first](#first) | what first shows | 0 of 1 hold |" in after
    assert after.count("## first\n") == after.count("[first](#first)") == 1
    assert "| 1 | 20 |" in section(after, "first")
    assert section(after, "third") == section(before, "third")


def test_a_table_that_there_is_no_more_leaves_the_page() -> None:
    before = results_page([content("first"), content("third")], ORDER)
    after = results_page([], ["third"], before)
    assert "first" not in after
    assert section(after, "third") == section(before, "third")


def test_the_page_of_this_checkout_is_kept_to_the_byte() -> None:
    """Its sections were written by this module, and writing none anew changes none of them."""
    page = (DOCS / "results.md").read_text(encoding="utf-8")
    assert results_page([], NAMES, page) == page


def test_quick_tables_are_not_for_the_page(tmp_path: Path) -> None:
    with pytest.raises(ReportError, match="no table yet"):
        write_report(lay(tmp_path / "none"), tmp_path / "docs", ORDER)
    quick = lay(tmp_path / "quick", content("first"), content("third", quick=True))
    with pytest.raises(ReportError, match="third came of --quick"):
        write_report(quick, tmp_path / "docs", ORDER)
    assert not (tmp_path / "docs").exists()
