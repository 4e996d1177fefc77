"""docs/results.md and its figures, from the tables in a folder of results."""

import json
import shutil
from collections.abc import Sequence
from pathlib import Path

from benchmarks.engine.page import results_page
from bha_common.files import atomic_write


class ReportError(ValueError):
    """There is nothing to write a page of."""


def write_report(results: Path, docs: Path, order: Sequence[str]) -> Path:
    """Write the tables in a folder into the page, and copy their figures beside it.

    Tables that stand on the page already and are not in the folder stay as they are: nobody has
    the results of all tables at hand.

    Parameters
    ----------
    results : Path
        Folder with NAME.json and NAME.png of the tables.
    docs : Path
        Folder of the page `results.md`; figures go to `images/`.
    order : sequence of str
        Names of all tables, in the order of the page.

    Raises
    ------
    ReportError
        If there is no table, or one was made in quick runs, which tell nothing.
    """
    names = [name for name in order if (results / f"{name}.json").is_file()]
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
    before = page.read_text(encoding="utf-8") if page.is_file() else ""
    atomic_write(page, results_page(tables, order, before).encode())
    return page
