"""Methods ranked within each condition, by one measure: a table a condition, the best method first.

Beside the measures stands the difference from the reference method, in pairs on the same trials, and beside the rank
the ranks that the trials do not rule out. Of aic and bic only differences between methods mean anything; they are given
above their smallest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from statistics import NormalDist
from typing import Any

import numpy as np

from simfield.block import Floats
from studies.summary.over_geometries import error_of
from studies.texts import escaped

Row = Mapping[str, Any]
ABOVE_SMALLEST = ("aic", "bic")
LEVEL = 0.05
"""how often, where there is no difference, any of the ranks of a condition is said to be ruled out"""


def largest_by_chance(differences: int, level: float = LEVEL) -> float:
    """How many standard errors the largest of so many differences that are none exceeds with the probability `level`.

    Sidak 1967: for independent ones exactly, for others less often.
    """
    return NormalDist().inv_cdf(0.5 + 0.5 * (1.0 - level) ** (1.0 / differences))


def possible_ranks(value: Floats, error: Floats, against: Floats) -> tuple[Floats, Floats]:
    """Best and worst rank (m) that each of m methods may have; the smallest value is the best.

    value (m) with standard error (m); against (m): the error of its difference from one reference in pairs, NaN for the
    reference itself and where there is none. Two methods are told apart where they differ by more than the largest of
    all pairs does by chance; the error of a pair is at most the sum of two errors, of the values or, where they are
    smaller, of the differences from the reference.
    """
    m = len(value)
    if m < 2:
        return np.ones(m), np.ones(m)
    paired = np.nan_to_num(against, nan=np.inf)
    reference = np.isnan(against)
    if reference.sum() == 1:  # the reference differs from itself by nothing
        paired[reference] = 0.0
    of_pair = np.fmin(error[:, None] + error, paired[:, None] + paired)
    apart = value[:, None] - value > largest_by_chance(m * (m - 1) // 2) * of_pair
    return 1.0 + apart.sum(axis=1), m - apart.sum(axis=0).astype(float)


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
    methods.sort(key=lambda m: estimate[m, by])
    own_error = {row["method"]: error_of(row) for row in rows if row["measure"] == by}
    paired = [error_of(against[m]) if m in against else np.nan for m in methods]
    best, worst = possible_ranks(
        np.array([estimate[m, by] for m in methods]), np.array([own_error[m] for m in methods]), np.array(paired)
    )
    yield "| rank | method | " + " | ".join([escaped(measures[0]), "difference", *map(escaped, measures[1:])]) + " |"
    yield "| --- | --- | " + " | ".join(["---:"] * (len(measures) + 1)) + " |"
    for number, method in enumerate(methods):
        rank = (
            f"{number + 1}"
            if best[number] == worst[number]
            else f"{number + 1} ({best[number]:.0f}–{worst[number]:.0f})"
        )
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
