"""The second level of error: rows of one situation in several geometries become one row.

The Monte-Carlo standard error over trials says how well a figure is known for one geometry. Other fields, flights and
points have other figures, and those scatter by several of these errors. With G geometries the estimate is the mean of
theirs, its error over trials is the root of the sum of the squares of theirs / G, and geometry_se, the standard
deviation of theirs / sqrt(G), holds both levels: the scatter of geometries, with the errors of their trials in it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

Row = dict[str, Any]
KEY = ("method", "against", "measure")
LAST = "failure_share"
"""the measure that ends every cell"""


def over_geometries(of_each: Sequence[Sequence[Row]], head: Row) -> list[Row]:
    """One row for each method and measure, in the order of the first geometry that has it; head replaces theirs.

    of_each: the rows of each geometry. Where a geometry has no value, because nothing could be adjusted in it, the
    others are told, and how many they are.
    """
    found: dict[tuple[Any, ...], list[Row]] = {}
    for rows in of_each:
        for row in rows:
            found.setdefault(tuple(row.get(name) for name in KEY), []).append(row)
    methods = {key[:2]: number for number, key in reversed(list(enumerate(found)))}
    order = sorted(found, key=lambda key: (methods[key[:2]], key[2] == LAST))
    return [{**found[key][0], **head, **_together(found[key])} for key in order]


def error_of(row: Mapping[str, Any]) -> float:
    """The standard error that belongs to the estimate: over geometries where there are several, else over trials."""
    return float(row.get("geometry_se", row["mcse"]))


def with_correlated(rows: Sequence[Row], least: float) -> Iterator[Row]:
    """The rows without those of pairs whose formal correlation, of all geometries, is less."""
    formal = {
        (row["method"], row["measure"].partition(" ")[2]): row["estimate"]
        for row in rows
        if row["measure"].startswith("formal_correlation ")
    }
    for row in rows:
        form, _, pair = row["measure"].partition(" ")
        if not form.endswith("correlation") or abs(formal[row["method"], pair]) >= least:
            yield row


def _together(rows: Sequence[Row]) -> Row:
    estimates = np.array([row["estimate"] for row in rows])
    known = np.isfinite(estimates)
    count = int(known.sum())
    errors = np.array([row["mcse"] for row in rows])[known]
    return {
        "n": sum(row["n"] for row in rows),
        "failures": sum(row["failures"] for row in rows),
        "estimate": float(estimates[known].mean()) if count else float("nan"),
        "mcse": float(np.sqrt(np.sum(errors**2)) / count) if count else float("nan"),
        "geometries": count,
        "geometry_se": float(estimates[known].std(ddof=1) / np.sqrt(count)) if count > 1 else float("nan"),
    }
