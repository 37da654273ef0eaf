"""Figures of the ground: the plan of a field, rays per point, error ellipses. Each draws on the axes it is given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from simfield.block import Block, Floats, Indices
from studies.comparison import PointErrors
from studies.figures.canvas import BLACK, BLUE, COLOURS, GREY, VERMILION, literal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection
    from matplotlib.colorbar import Colorbar
    from matplotlib.figure import Figure

MARKS: Mapping[str, tuple[str, str, float]] = {
    "control": ("^", BLACK, 34.0),
    "check": ("o", GREY, 7.0),
    "tie": (".", GREY, 7.0),
}
"""the usual signs: a triangle for control"""
KILOMETRE = 1000.0
MARGIN = 1.15
"""times the longest bar: what the frame of a map of errors leaves around the points"""


def field_plan(axes: Axes, block: Block, footprints: Floats) -> None:
    """Points by their role, exposure stations, and the outlines of the images (m, 4, 2) on the ground, m."""
    from matplotlib.collections import LineCollection

    for number, camera in enumerate(block.cameras):
        own = block.images.camera == number
        if not own.any():
            continue
        outlines = np.concatenate([footprints[own], footprints[own][:, :1]], axis=1) / KILOMETRE
        colour = COLOURS[number % len(COLOURS)]
        axes.add_collection(LineCollection(list(outlines), colors=colour, linewidths=0.7, alpha=0.55))
        label = f"{own.sum()} images, {literal(camera.camera_id)}"
        stations = block.images.exterior[own, :2] / KILOMETRE
        axes.plot(*stations.T, color=colour, marker="+", markersize=6, linestyle="none", label=label)
    for role, (marker, colour, size) in MARKS.items():
        x, y = block.points.coordinates[block.points.role == role, :2].T / KILOMETRE
        if len(x):
            label, above = f"{len(x)} {role} points", 4 if role == "control" else 3
            axes.scatter(x, y, marker=marker, s=size, color=colour, label=label, zorder=above)
    axes.autoscale_view()
    _ground(axes)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2, fontsize=7.5)


def rays_per_point(axes: Axes, xy_m: Floats, rays: Indices) -> PathCollection:
    """The number of images in which each point at xy_m (n, 2) was measured; the marks, for a colour bar.

    Points with many rays are drawn first, so that a weak one is never hidden.
    """
    order = np.argsort(-rays, kind="stable")
    x, y = xy_m[order].T / KILOMETRE
    marks = axes.scatter(x, y, c=rays[order], cmap="cividis_r", s=26.0, edgecolors=BLACK, linewidths=0.4)
    _ground(axes)
    return marks


def rays_bar(figure: Figure, axes: Axes, marks: PathCollection, shrink: float = 0.8) -> Colorbar:
    """The colour bar of the marks beside the axes; nobody measures in half an image."""
    from matplotlib.ticker import MaxNLocator

    label, whole = "images in which the point was measured", MaxNLocator(integer=True)
    return figure.colorbar(marks, ax=axes, shrink=shrink, label=label, ticks=whole)


def error_ellipses(axes: Axes, errors: PointErrors, unit_mm: float, unit_ground_m: float) -> None:
    """One-sigma ellipses at the points and beside them upright bars of the height error.

    An error of unit_mm is as long as unit_ground_m of the field.
    """
    from matplotlib.collections import EllipseCollection

    times = unit_ground_m / unit_mm * 1000.0 / KILOMETRE
    x, y = errors.xy_m.T / KILOMETRE
    width, height = 2.0 * times * errors.semi_m.T
    outline = {"facecolors": "none", "edgecolors": BLUE, "linewidths": 0.9}
    at = {"offsets": np.column_stack([x, y]), "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(width, height, np.degrees(errors.angle), units="xy", **at, **outline))
    axes.vlines(x, y, y + times * errors.height_m, color=VERMILION, linewidth=1.6, label="height, one sigma")
    axes.plot([], [], linestyle="none", marker="o", fillstyle="none", color=BLUE, label="plan, one-sigma ellipse")
    axes.plot(x, y, linestyle="none", marker=".", markersize=2.5, color=BLACK)
    reach = MARGIN * times * max(float(errors.semi_m.max(initial=0.0)), float(errors.height_m.max(initial=0.0)))
    axes.set(xlim=(x.min() - reach, x.max() + reach), ylim=(y.min() - reach, y.max() + reach))
    _ground(axes)
    axes.locator_params(nbins=6)
    axes.set_xlabel(f"X, km\nan error of {unit_mm:g} mm is drawn as long as {unit_ground_m:g} m of the field")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, fontsize=7.5)


def _ground(axes: Axes) -> None:
    axes.set(xlabel="X, km", ylabel="Y, km", aspect="equal")
