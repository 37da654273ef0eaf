"""The figure of a study: measures over a factor, with 95 % Monte-Carlo intervals. Draws on the axes it is given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from simfield.block import Floats
from studies.figures.canvas import COLOURS, MARKERS, literal
from studies.summary import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_SERIES = 12
INTERVAL = 1.96
Series = Mapping[str, tuple[Floats, Floats, Floats]]
"""label: x, estimates and their Monte-Carlo standard errors"""


def series_of(rows: Sequence[Row], measure: str, x: str, names: Sequence[str]) -> tuple[Series, list[str]]:
    """The series of a measure over column x, one for each combination of the other columns; and the labels of x if its
    values are no numbers.
    """
    chosen = [row for row in rows if row["measure"] == measure and np.isfinite(row["estimate"])]
    values = list(dict.fromkeys(row[x] for row in chosen))
    numeric = all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)
    place = {v: float(v) if numeric else float(i) for i, v in enumerate(values)}
    varying = [name for name in names if name != x and len({str(row[name]) for row in rows}) > 1]
    grouped: dict[str, list[tuple[float, float, float]]] = {}
    for row in chosen:
        label = ", ".join(_said(name, row[name]) for name in varying)
        grouped.setdefault(label, []).append(
            (place[row[x]], row["estimate"], row["geometry_se" if "geometry_se" in row else "mcse"])
        )
    series = {}
    for label, points in grouped.items():
        columns = np.array(sorted(points)).T
        series[label] = (columns[0], columns[1], columns[2])
    return series, [] if numeric else [_plain(v) for v in values]


def with_unit(measure: str, unit: str) -> str:
    """A measure as the label of an axis."""
    return literal(measure) + ("" if unit == "1" else f", {unit.replace('um', 'µm')}")


def _said(name: str, value: Any) -> str:
    if name == "aux_points":
        return "with aux" if value else "without aux"
    return _plain(value) if name in ("ap", "cameras") else f"{name} {_plain(value)}"


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else literal(str(value))


MANY_LABELS = 8
"""more names than this along x stand upright, and are joined by no lines"""


def measure_over_factor(axes: Axes, series: Series, labels: Sequence[str], x: str, measure: str, unit: str) -> None:
    """One measure over a factor: points with 95 % Monte-Carlo intervals, a line for each series."""
    count = max(1, len(series))
    for number, (label, (places, estimate, mcse)) in enumerate(list(series.items())[:MOST_SERIES]):
        style: dict[str, Any] = {"color": COLOURS[number % len(COLOURS)], "marker": MARKERS[number % len(MARKERS)]}
        if len(labels) > MANY_LABELS:
            style["linestyle"] = "none"
        elif number >= len(COLOURS):
            style["linestyle"] = (0, (4, 2))
        # side by side where x is a list of names, so that intervals do not hide each other
        shift = (number - (count - 1) / 2.0) * 0.5 / count if labels else 0.0
        error = INTERVAL * np.nan_to_num(mcse)
        axes.errorbar(
            places + shift, estimate, yerr=error, label=label, markersize=3.5, linewidth=0.9, capsize=1.5, **style
        )
    if labels:
        axes.set_xticks(range(len(labels)), labels)
        if len(labels) > MANY_LABELS:
            axes.tick_params(axis="x", labelrotation=90, labelsize=6)
        elif sum(map(len, labels)) > 40:
            axes.tick_params(axis="x", labelrotation=25)
    axes.set(xlabel=_plain(x), ylabel=with_unit(measure, unit))
    axes.grid(True, axis="y")
