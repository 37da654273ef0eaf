"""Figures: each function draws data on the axes it is given, and does nothing else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from simfield.block import Floats
from studies.comparison import RadialCurve, VectorField
from studies.figures.canvas import BLACK, BLUE, COLOURS, GREEN, GREY, MARKERS, VERMILION

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh

POINT_UNIT_MM = 10.0
HALF_FORMAT_MM = 115.0
FEW = 8
"""unknowns of a heat map whose cells have room for larger numbers"""
LINE = 30
"""characters that fit below a heat map side by side"""
WHITE_ABOVE, WHITE_BELOW = 0.62, -0.77
"""correlations whose cells are so dark that white numbers have more contrast than black ones"""
DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.5, 1.5)), (0, (5, 1.5, 1.5, 1.5)))


def radius_histogram(axes: Axes, counts: Mapping[str, Floats], edges_mm: Floats) -> None:
    """Points in an image by their radius: a series of bars for each entry of counts, drawn behind each other."""
    for (label, heights), colour in zip(counts.items(), (BLUE, VERMILION), strict=False):
        axes.stairs(heights, edges_mm, fill=True, alpha=0.35, color=colour)
        axes.stairs(heights, edges_mm, color=colour, label=f"{label}: {heights.sum():.0f} points")
    axes.set(xlabel="image radius, mm", ylabel="points in 10 mm of radius", xlim=(edges_mm[0], edges_mm[-1]))
    axes.set_ylim(0, 1.3 * max(heights.max() for heights in counts.values()))
    axes.legend(loc="upper left")


def radial_curve(axes: Axes, curve: RadialCurve, others: Mapping[str, RadialCurve]) -> None:
    """The radial-symmetric distortion from additional parameters with its standard deviation, and the true one.

    Curves of other models are drawn thinly, with their labels.
    """
    low, high = curve.estimated_um - curve.std_um, curve.estimated_um + curve.std_um
    axes.fill_between(curve.r_mm, low, high, color=BLUE, alpha=0.25, linewidth=0, label="± its standard deviation")
    axes.plot(curve.r_mm, curve.estimated_um, color=BLUE, label="from additional parameters")
    axes.plot(curve.r_mm, curve.true_um, color=BLACK, linestyle=(0, (4, 2)), label="true")
    for (label, other), colour, dash in zip(others.items(), (VERMILION, GREEN), DASHES[1:], strict=False):
        axes.plot(other.r_mm, other.estimated_um, color=colour, linestyle=dash, linewidth=1.0, label=label)
    radial_frame(axes, curve.r0_mm)
    axes.legend(loc="lower left", fontsize=7.5)


def true_radial_curve(axes: Axes, curve: RadialCurve) -> None:
    """The true radial-symmetric distortion alone, in the place of a laboratory calibration."""
    axes.plot(curve.r_mm, curve.true_um, color=BLACK)
    radial_frame(axes, curve.r0_mm)


def radial_frame(axes: Axes, r0_mm: float) -> None:
    """The labels of a radial curve, a zero line and the place of the second zero."""
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    axes.plot([r0_mm], [0.0], marker="|", color=GREY, markersize=8)
    axes.set(xlabel="image radius, mm", ylabel="radial distortion, µm", xlim=(0, 150))


def vectors(axes: Axes, field: VectorField, behind: VectorField | None, unit_um: float) -> None:
    """Vectors of distortion or of residuals at image points with a legend in the paper's units, others behind in grey.

    A vector of unit_um is as long as one unit of the point grid.
    """
    if behind is not None:
        _arrows(axes, behind, unit_um, color=GREY, width=0.007)
    _arrows(axes, field, unit_um, color=BLUE, width=0.005)
    edge = HALF_FORMAT_MM * np.array([-1.0, 1.0, 1.0, -1.0, -1.0])
    axes.plot(edge, np.roll(edge, 1), color=GREY, linewidth=0.7)
    limit = HALF_FORMAT_MM + 5.0
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", xticks=(-100, 0, 100), yticks=(-100, 0, 100))
    axes.set_ylabel("y, mm")
    axes.set_xlabel(
        f"x in flight direction, mm\nquadratic mean of the vectors {field.rms_um:.1f} µm\n"
        f"unit of the point grid {POINT_UNIT_MM:g} mm, of the vectors {unit_um:g} µm"
    )


def _arrows(axes: Axes, field: VectorField, unit_um: float, *, color: str, width: float) -> None:
    axes.plot(*field.xy_mm.T, linestyle="none", marker=".", markersize=2, color=color)
    heads: dict[str, Any] = {"headwidth": 3.5, "headlength": 4.0, "headaxislength": 3.6, "width": width}
    scale = unit_um / POINT_UNIT_MM
    axes.quiver(*field.xy_mm.T, *field.vectors_um.T, angles="xy", scale_units="xy", scale=scale, color=color, **heads)


def correlation_matrix(axes: Axes, upper: Floats, lower: Floats, names: Sequence[str]) -> QuadMesh:
    """Two correlation matrices in one, in hundredths: `upper` above the diagonal, `lower` below; the coloured mesh."""
    size = len(names)
    both = np.triu(upper, 1) + np.tril(lower, -1)
    mesh = axes.pcolormesh(both, cmap="PuOr", vmin=-1.0, vmax=1.0, edgecolors="white", linewidth=0.4)
    letters = 6.0 if size > FEW else 7.5
    for i, j in zip(*np.nonzero(np.abs(both) >= 0.095), strict=True):
        dark = both[i, j] > WHITE_ABOVE or both[i, j] < WHITE_BELOW
        text = f"{100 * both[i, j]:.0f}".replace("-", "−")
        axes.text(j + 0.5, i + 0.5, text, ha="center", va="center", fontsize=letters, color="white" if dark else BLACK)
    axes.plot([0, size], [0, size], color=GREY, linewidth=0.7)
    axes.set(xlim=(0, size), ylim=(size, 0), aspect="equal")
    axes.set_xticks(np.arange(size) + 0.5, names, fontsize=7.5, rotation=90 if sum(map(len, names)) > LINE else 0)
    axes.set_yticks(np.arange(size) + 0.5, names, fontsize=7.5)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return mesh


def correlation_rectangle(axes: Axes, values: Floats, rows: Sequence[str], columns: Sequence[str]) -> QuadMesh:
    """Correlations of some unknowns (rows) with others (columns), values (rows, columns); the coloured mesh."""
    mesh = axes.pcolormesh(values, cmap="PuOr", vmin=-1.0, vmax=1.0, edgecolors="white", linewidth=0.4)
    axes.set(xlim=(0, len(columns)), ylim=(len(rows), 0))
    axes.set_xticks(
        np.arange(len(columns)) + 0.5, columns, fontsize=7.5, rotation=90 if sum(map(len, columns)) > LINE else 0
    )
    axes.set_yticks(np.arange(len(rows)) + 0.5, rows, fontsize=7.5)
    axes.tick_params(length=0)
    axes.spines[:].set_visible(False)
    return mesh


def lines(axes: Axes, x: Floats, series: Mapping[str, Floats]) -> None:
    """A line for each series, told apart by colour and by dash."""
    for (label, y), colour, dash in zip(series.items(), COLOURS, DASHES, strict=False):
        axes.plot(x, y, color=colour, linestyle=dash, label=label)


def falling_errors(axes: Axes, series: Mapping[str, tuple[Floats, Floats]], *, dashed: bool) -> None:
    """Standard errors against redundancy on logarithmic axes: (redundancy, error) for each label."""
    for (label, (x, y)), colour, marker in zip(series.items(), COLOURS, MARKERS, strict=False):
        style: dict[str, Any] = {"linestyle": DASHES[1], "fillstyle": "none"} if dashed else {}
        axes.plot(x, y, color=colour, marker=marker, markersize=4.5, linewidth=1.0, label=label, **style)
    axes.set(xscale="log", yscale="log")
    axes.grid(True, which="major")


def ranges(axes: Axes, labels: Sequence[str], published: Floats, simulated: Mapping[str, tuple[Floats, ...]]) -> None:
    """Published figures row by row, beside mean and range (mean, low, high) of simulated ones."""
    places = np.arange(len(labels), dtype=float)
    offsets = np.linspace(-0.18, 0.18, len(simulated)) if len(simulated) > 1 else [0.0]
    for (label, (mean, low, high)), offset, colour in zip(simulated.items(), offsets, COLOURS, strict=False):
        axes.hlines(places + offset, low, high, color=colour, linewidth=2.0, alpha=0.45)
        axes.plot(mean, places + offset, linestyle="none", marker="o", markersize=3.2, color=colour, label=label)
    axes.plot(
        published,
        places,
        linestyle="none",
        marker="D",
        markersize=4.5,
        color=BLACK,
        fillstyle="none",
        label="published 1980",
    )
    axes.set_yticks(places, labels, fontsize=7.5)
    largest = max(float(published.max()), *(float(high.max()) for _, _, high in simulated.values()))
    axes.set(ylim=(len(labels) - 0.5, -0.5), xlim=(0, 1.05 * largest))
    axes.tick_params(axis="y", length=0)
    axes.grid(True, axis="x")
