"""Methods ranked within each condition, by one measure: a table a condition, the best method first.

Beside the measures stands the difference from the reference method, in pairs on the same trials. Of aic and bic only
differences between methods mean anything; they are given above their smallest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from studies.summary.over_geometries import error_of
from studies.texts import escaped

Row = Mapping[str, Any]
ABOVE_SMALLEST = ("aic", "bic")


def tables(rows: Sequence[Row], differences: Sequence[Row], measures: Sequence[str], by: str) -> Iterator[str]:
    """Lines in Markdown; rows and differences as in studies.summary.summary.Summary, measures are the columns."""
    for condition in dict.fromkeys(row["condition"] for row in rows):
        own = [row for row in rows if row["condition"] == condition]
        against = {row["method"]: row for row in differences if row["condition"] == condition and row["measure"] == by}
        yield from _table(own, against, [by, *(m for m in measures if m != by)], by)
        yield ""


def _table(rows: Sequence[Row], against: Mapping[str, Row], measures: Sequence[str], by: str) -> Iterator[str]:
    estimate = {(row["method"], row["measure"]): float(row["estimate"]) for row in rows}
    methods = [m for m in dict.fromkeys(row["method"] for row in rows) if np.isfinite(estimate.get((m, by), np.nan))]
    least = {m: min(estimate.get((k, m), np.inf) for k in methods) for m in measures if m in ABOVE_SMALLEST}
    yield "| rank | method | " + " | ".join([escaped(measures[0]), "difference", *map(escaped, measures[1:])]) + " |"
    yield "| ---: | --- | " + " | ".join(["---:"] * (len(measures) + 1)) + " |"
    for rank, method in enumerate(sorted(methods, key=lambda m: estimate[m, by]), start=1):
        cells = [_number(estimate.get((method, m), np.nan) - least.get(m, 0.0)) for m in measures]
        cells.insert(1, _difference(against.get(method)))
        name = escaped(method.partition(", cameras ")[0])
        yield f"| {rank} | {name} | " + " | ".join(cells) + " |"


def _difference(row: Row | None) -> str:
    return f"{row['estimate']:+.2f} ± {error_of(row):.2f}" if row is not None and np.isfinite(error_of(row)) else "–"


def _number(value: float) -> str:
    if not np.isfinite(value):
        return "–"
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"
