"""The picture of the front page: a scenario, an image of its block, what an adjustment found, what a study asks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from simfield.files import make_folder, write_whole
from studies import figures
from studies.comparison import block_views, distortion_found
from studies.gallery.pieces import CAMERA, MODEL, Example

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Scenario, block, adjustment, study"
SAYS = (
    "Four pictures in a row. A plan of the field with the outlines of 39 images; the points of one image; radial "
    "distortion as an adjustment found it, with a band of one standard deviation and the true curve dashed; the errors "
    "of a height in 512 trials, in the standard deviations that the adjustments claim, beside the distribution that "
    "they should have."
)
HALF_FORMAT_MM = 115.0


def overview(example: Example) -> Figure:
    """Four panels; the colours are dark enough for the white card that they stand on."""
    figure = figures.new_figure(270, 72)
    plan, image, curve, errors = figure.subplots(1, 4, width_ratios=(1.0, 0.95, 1.15, 1.15))
    _plan(plan, example)
    _image(image, example)
    _curve(curve, example)
    _errors(errors, example)
    titles = (
        "1  a scenario is flown",
        "2  a block is measured",
        "3  the adjustment is blind",
        "4  a study asks thousands",
    )
    figure.get_layout_engine().set(rect=(0.004, 0.0, 0.988, 0.9))  # type: ignore[union-attr, call-arg]
    for left, title in zip((0.035, 0.275, 0.485, 0.765), titles, strict=True):
        figure.text(left, 0.93, title, fontweight="bold")
    return figure


def _plan(axes: Axes, example: Example) -> None:
    figures.field_plan(axes, example.block, block_views.footprints(example.block))
    legend = axes.get_legend()
    if legend is not None:
        legend.remove()
    axes.set(xlabel="X, km", ylabel="Y, km")


def _image(axes: Axes, example: Example) -> None:
    block = example.wide
    own = block.observations.image == int(np.argmax(np.bincount(block.observations.image)))
    axes.plot(*block.observations.xy[own].T, marker=".", markersize=3.5, linestyle="none", color=figures.BLUE)
    edge = HALF_FORMAT_MM * np.array([-1.0, 1.0, 1.0, -1.0, -1.0])
    axes.plot(edge, np.roll(edge, 1), color=figures.GREY, linewidth=0.7)
    axes.set(aspect="equal", xlabel=f"x, mm   ({own.sum()} points of one image)", ylabel="y, mm")
    axes.set(xticks=(-100, 0, 100), yticks=(-100, 0, 100))


def _curve(axes: Axes, example: Example) -> None:
    figures.radial_curve(axes, distortion_found.radial_curve(example.full, CAMERA, example.truth), {})


def _errors(axes: Axes, example: Example) -> None:
    """Errors of the height of the first point that is no control, in claimed standard deviations."""
    r = example.many(MODEL)
    point = int(np.flatnonzero(np.asarray(example.block.points.role) != "control")[0])
    true = example.truth.coordinates[example.truth.point_ids.index(example.block.points.ids[point]), 2]
    std = r.std[:, r.nominal.layout.orientation + 3 * point + 2]
    ratio = ((r.points[:, point, 2] - true) / std)[r.ok]
    edges = np.linspace(-4.0, 4.0, 25)
    axes.hist(ratio, edges.tolist(), density=True, color=figures.BLUE, alpha=0.4, label=f"{len(ratio)} trials")
    fine = np.linspace(-4.0, 4.0, 161)
    axes.plot(
        fine, stats.t.pdf(fine, r.nominal.redundancy), color=figures.BLACK, linestyle=(0, (4, 2)), label="as claimed"
    )
    axes.set(xlabel="error of a height / its standard deviation", ylabel="density", xlim=(-4, 4), ylim=(0, 0.56))
    axes.legend(loc="upper left", fontsize=7.5, ncols=2)


def write_overview(folder: Path) -> Path:
    """Write figures/overview.svg into a folder; the file. Raises OSError."""
    path = folder / "figures" / "overview.svg"
    make_folder(path.parent)
    with figures.house_style():
        write_whole(path, figures.svg(overview(Example()), TITLE, SAYS).encode())
    return path
