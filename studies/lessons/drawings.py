"""The figures of the lessons: each function draws data on the axes it is given; nothing is computed here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from simfield.block import Floats
from studies.comparison import VectorField
from studies.figures import BLACK, BLUE, COLOURS, GREEN, GREY, HALF_FORMAT_MM, MARKERS, ORANGE, POINT_UNIT_MM, VERMILION
from studies.lessons.gross_error import CRITICAL, SIZE_MOST_UM, Planted
from studies.lessons.interval import Repeated
from studies.lessons.own_block import Expected
from studies.lessons.redundancy import Flown
from studies.lessons.second_zero import RADII_MM, Correlated
from studies.lessons.which_model import Compared

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection

INTERVALS_SHOWN = 100


def standard_errors(axes: Axes, flights: Sequence[Flown], chosen: Flown, quantity: str, label: str) -> None:
    """A standard error of Flown over its redundancy, for all headings and group sizes, the chosen flight ringed."""
    for headings, colour, marker in zip((1, 2, 4), COLOURS, MARKERS, strict=False):
        own = [f for f in flights if f.headings == headings]
        x, y = [f.counts.redundancy for f in own], [getattr(f, quantity) for f in own]
        name = "1 heading" if headings == 1 else f"{headings} headings"
        axes.plot(x, y, color=colour, marker=marker, markersize=5, label=name)
    here = chosen.counts.redundancy, getattr(chosen, quantity)
    axes.plot(*here, marker="o", markersize=13, fillstyle="none", color=BLACK, markeredgewidth=1.2)
    r = np.array([flights[0].counts.redundancy, flights[-1].counts.redundancy], dtype=float)
    first = getattr(flights[0], quantity)
    axes.plot(r, first * np.sqrt(r[0] / r), color=GREY, linestyle=(0, (2, 2)), linewidth=1.0, label="as 1/√r")
    axes.set(xscale="log", yscale="log", xlabel="redundancy r", ylabel=label)
    _plain_ticks(axes)


def correlations(axes: Axes, curve: Sequence[Correlated], here: Correlated) -> None:
    """Mean |R(Z0,a3)| and |R(Z0,a4)| over r0, the chosen r0 marked."""
    r0 = [c.r0_mm for c in curve]
    for name, quantity, colour, marker in (("a3", "z0_a3", BLUE, "o"), ("a4", "z0_a4", VERMILION, "s")):
        axes.plot(r0, [getattr(c, quantity) for c in curve], color=colour, label=f"|R(Z0, {name})|")
        axes.plot([here.r0_mm], [getattr(here, quantity)], color=colour, marker=marker, markersize=8)
    axes.axvline(here.r0_mm, color=GREY, linewidth=0.7)
    axes.set(xlabel="second zero r0, mm", ylabel="correlation, mean of the middle images", ylim=(0, 1), xlim=(-3, 143))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.13), ncols=2)


def radial_with_second_zero(axes: Axes, without: Correlated, here: Correlated) -> None:
    """The radial distortion as found with r0 = 0 and with the chosen r0, each with its standard deviation."""
    for found, colour, name in ((without, GREY, "r0 = 0"), (here, BLUE, f"r0 = {here.r0_mm:.0f} mm")):
        low, high = found.radial_um - found.radial_std_um, found.radial_um + found.radial_std_um
        axes.fill_between(RADII_MM, low, high, color=colour, alpha=0.3, linewidth=0)
        axes.plot(RADII_MM, found.radial_um, color=colour, label=name)
    axes.axhline(0.0, color=GREY, linewidth=0.7)
    axes.plot([here.r0_mm], [0.0], marker="o", markersize=6, color=BLUE)
    axes.set(xlabel="image radius, mm", ylabel="radial distortion ± standard deviation, µm", xlim=(0, 150))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.13), ncols=2)


def distortion_field(axes: Axes, field: VectorField, title: str, unit_um: float) -> None:
    """Vectors over the format; one of unit_um is as long as 10 mm of the image."""
    heads: dict[str, Any] = {"headwidth": 3.5, "headlength": 4.0, "headaxislength": 3.6, "width": 0.006}
    scale = unit_um / POINT_UNIT_MM
    axes.quiver(*field.xy_mm.T, *field.vectors_um.T, angles="xy", scale_units="xy", scale=scale, color=BLUE, **heads)
    axes.plot(*field.xy_mm.T, linestyle="none", marker=".", markersize=2, color=BLUE)
    edge = HALF_FORMAT_MM * np.array([-1.0, 1.0, 1.0, -1.0, -1.0])
    axes.plot(edge, np.roll(edge, 1), color=GREY, linewidth=0.7)
    limit = HALF_FORMAT_MM + 15.0
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", xticks=(-100, 0, 100), yticks=(-100, 0, 100))
    axes.set(title=title, ylabel="y, mm", xlabel=f"x, mm; vectors: 10 mm are {unit_um:g} µm")


def sets_compared(axes: Axes, found: Compared, chosen: str) -> None:
    """For each set, how much larger m0 and the check points' errors are than with the best set."""
    names = list(found.fitted)
    rows = np.arange(len(names))
    series = (("m0", "m0_um", "o"), ("error of X, Y", "rms_xy_mm", "s"), ("error of Z", "rms_z_mm", "^"))
    for (label, quantity, marker), colour, offset in zip(series, COLOURS, (-0.15, 0.0, 0.15), strict=False):
        values = np.array([getattr(f, quantity) for f in found.fitted.values()])
        ratio = values / values.min()
        axes.plot(ratio, rows + offset, color=colour, marker=marker, linestyle="none", markersize=7, label=label)
    axes.axvline(1.0, color=GREY, linewidth=0.7)
    axes.axhspan(names.index(chosen) - 0.4, names.index(chosen) + 0.4, color=ORANGE, alpha=0.18, linewidth=0)
    axes.set_yticks(rows, names)
    axes.set(ylim=(len(names) - 0.4, -0.6), xlabel="times that of the best set")
    axes.set_xlim(left=0.9, right=max(1.5, axes.get_xlim()[1]))
    axes.grid(True, axis="x")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=3, columnspacing=0.8, handletextpad=0.1)


def zip_plot(axes: Axes, found: Repeated) -> None:
    """The first intervals, sorted by how far their estimates miss in units of their half widths."""
    shown = np.arange(min(INTERVALS_SHOWN, len(found.error_mm)))
    order = shown[np.argsort(found.error_mm[shown] / found.half_width_mm[shown])]
    rows = np.arange(len(order))
    for inside, colour, name in ((True, BLUE, "with the truth inside"), (False, VERMILION, "without")):
        own = found.inside[order] == inside
        middle, half = found.error_mm[order][own], found.half_width_mm[order][own]
        axes.hlines(rows[own], middle - half, middle + half, color=colour, linewidth=1.1, label=f"{own.sum()} {name}")
        axes.plot(middle, rows[own], linestyle="none", marker=".", markersize=2.5, color=colour)
    axes.axvline(0.0, color=BLACK, linewidth=0.9)
    reach = float(np.max(np.abs(found.error_mm[shown]) + found.half_width_mm[shown]))
    axes.set(xlabel="interval minus true value, mm", ylabel="trials, sorted", yticks=[], xlim=(-reach, reach))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.12), ncols=2)


def running_coverage(axes: Axes, found: Repeated, confidence: float) -> None:
    """The share of intervals that contain the truth after 1, 2, ... trials, with two Monte-Carlo standard errors."""
    n = np.arange(1, len(found.error_mm) + 1)
    share = np.cumsum(found.inside) / n
    band = 2.0 * np.sqrt(confidence * (1.0 - confidence) / n)
    low, high = 100.0 * (confidence - band), 100.0 * np.minimum(confidence + band, 1.0)
    axes.fill_between(n, low, high, color=GREY, alpha=0.3, linewidth=0, label="95 % ± 2 Monte-Carlo standard errors")
    axes.axhline(100.0 * confidence, color=BLACK, linewidth=0.9)
    axes.plot(n, 100.0 * share, color=BLUE, label="found")
    bottom = min(70.0, 100.0 * float(share[-1]) - 10.0)
    axes.set(
        xlabel="trials", ylabel="intervals with the truth inside, %", ylim=(max(bottom, 0.0), 101.0), xlim=(1, n[-1])
    )
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.12), ncols=2)


def tests(axes: Axes, found: Planted) -> None:
    """|w| of every image coordinate with the critical value; the falsified and the accused ones marked."""
    rows = np.arange(len(found.w))
    w = np.abs(found.w)
    axes.plot(rows, w, linestyle="none", marker=".", markersize=3, color=GREY, label="all image coordinates")
    axes.axhline(CRITICAL, color=BLACK, linewidth=0.9, linestyle=(0, (4, 2)))
    axes.text(len(w), CRITICAL + 0.1, f"{CRITICAL:.2f}", ha="right", va="bottom")
    # control rows come after the image coordinates and have no place here
    accused = [row for row in found.accused if row < len(w)]
    axes.plot(
        *(accused, w[accused], "o"),
        color=VERMILION,
        fillstyle="none",
        markersize=11,
        label="accused",
    )
    axes.plot(
        found.row, w[found.row], marker="D", linestyle="none", markersize=6, color=BLUE, label="the falsified one"
    )
    axes.set(xlabel="image coordinate, number", ylabel="|w|, standardised residual", ylim=(0, max(5.0, 1.12 * w.max())))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=3, columnspacing=1.0, handletextpad=0.2)


def power(axes: Axes, found: Planted, asked: float) -> None:
    """The probability that an error in this coordinate is noticed, over its size."""
    size = np.linspace(0.0, SIZE_MOST_UM, 201)
    axes.plot(size, 100.0 * found.power(size), color=BLUE)
    axes.plot([abs(found.size_um)], [100.0 * found.power(abs(found.size_um))], marker="D", markersize=7, color=BLUE)
    if found.mdb_um <= SIZE_MOST_UM:
        axes.plot([found.mdb_um, found.mdb_um], [0, 100.0 * asked], color=BLACK, linewidth=0.9, linestyle=(0, (4, 2)))
        axes.text(found.mdb_um + 1.0, 4.0, f"minimal detectable\n{found.mdb_um:.0f} µm", va="bottom")
    else:
        axes.text(0.5 * SIZE_MOST_UM, 50.0, f"minimal detectable: {found.mdb_um:.0f} µm", ha="center")
    axes.set(
        xlabel="size of the error, µm", ylabel="probability to be noticed, %", ylim=(0, 103), xlim=(0, SIZE_MOST_UM)
    )


def accuracy_map(axes: Axes, found: Expected) -> PathCollection:
    """The expected standard deviation of the heights over the area, control, and where the images are taken."""
    axes.plot(*found.exterior[:, :2].T / 1000.0, linestyle="none", marker="+", markersize=5, color=GREY, label="images")
    free = ~found.control
    x, y = found.places[free].T / 1000.0
    dots = axes.scatter(x, y, c=found.std_mm[free, 2], cmap="viridis_r", s=36)
    label = "control"
    axes.plot(*found.places[found.control].T / 1000.0, linestyle="none", marker="^", color=VERMILION, label=label)
    axes.set(xlabel="X, km", ylabel="Y, km", aspect="equal")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14), ncols=2)
    return dots


def expected_bars(axes: Axes, found: Expected) -> None:
    """Expected standard deviations beside the rules of thumb."""
    names = ("X, Y", "Z", "Z, worst point")
    values: Floats = np.array([found.rms_xy_mm, found.rms_z_mm, found.worst_z_mm])
    axes.barh(np.arange(3), values, height=0.5, color=BLUE)
    for row, value in enumerate(values):
        axes.text(value, row, f" {value:.0f}", va="center", color=BLACK)
    rule = (found.rule_xy_mm, found.rule_z_mm)
    axes.plot(rule, (0, 1), linestyle="none", marker="|", markersize=26, markeredgewidth=2.0, color=GREEN)
    axes.plot(
        [], [], linestyle="none", marker="|", markersize=10, markeredgewidth=2.0, color=GREEN, label="rule of thumb"
    )
    axes.set_yticks(range(3), names)
    axes.set(xlabel="expected standard deviation, mm", ylim=(2.6, -0.6), xlim=(0, 1.18 * max(*values, *rule)))
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, 1.14))


def _plain_ticks(axes: Axes) -> None:
    """Numbers on logarithmic axes as 20, 50, 100 instead of powers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())
