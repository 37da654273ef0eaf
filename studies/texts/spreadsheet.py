"""Text in CSV files that no spreadsheet takes for a formula."""

from __future__ import annotations

FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""what a spreadsheet takes for the beginning of a formula"""


def as_text(cell: str) -> str:
    """The cell, with an apostrophe before what a spreadsheet would run; numbers and a lone dash are left alone."""
    if len(cell) < 2 or not cell.startswith(FORMULA):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell
