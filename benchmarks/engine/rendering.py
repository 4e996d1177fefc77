"""Values of a table as people read them, in the terminal and on a page."""

from typing import Any


def shown(value: Any) -> str:
    """Return a value in a few characters: numbers with three digits, nothing as a dash."""
    if value is None:
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        # 1234.5 as 1234, 0.0012345 as 0.00123; the exponent only where it is needed.
        return f"{value:.0f}" if 1e3 <= abs(value) < 1e7 else f"{value:.3g}"
    return str(value)


def columns(rows: list[dict[str, Any]]) -> list[str]:
    """Return the heads of the columns: the keys of the first row, then any others."""
    return list(dict.fromkeys(name for row in rows for name in row))


def bound_rows(bounds: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return bounds as the rows of a table."""
    return [
        {
            "bound": f"{bound['what']} {bound['bound']}",
            "measured": bound["measured"],
            "": _judged(bound),
        }
        for bound in bounds
    ]


def _judged(bound: dict[str, Any]) -> str:
    if bound["measured"] is None:
        return "not measured"
    return "holds" if bound["holds"] else "MISSED"
