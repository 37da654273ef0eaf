"""The gallery: every figure that this project draws, on data of one simulated experiment, with what it is good for.

python -m studies.gallery [FOLDER]      writes gallery.md and gallery/*.svg, into docs if no folder is named
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from simfield.files import make_folder, write_whole
from studies.figures import house_style, svg
from studies.gallery import pieces
from studies.gallery.pieces import SEED, Example

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Piece:
    """A figure of the gallery: file name, title, what it shows (the alternative text), the function that draws it."""

    name: str
    title: str
    says: str
    by: str
    draw: Callable[[Example], Figure]


PIECES: Sequence[Piece] = (
    Piece(
        "plan", "Plan of the field with footprints",
        "Map of the test field: 41 groups of points, five of them control, and the outlines of 39 images on the ground "
        "in the colours of two cameras.", "figures.field_plan", pieces.plan,
    ),
    Piece(
        "rays", "Rays per point",
        "Map of the points, coloured by the number of images in which each was measured: many in the middle, few at "
        "the edge.", "figures.rays_per_point", pieces.rays,
    ),
    Piece(
        "radii", "Radius histogram",
        "Number of image points by their distance from the image centre, with and without auxiliary points: what the "
        "radial distortion can be determined from.", "figures.radius_histogram", pieces.radii,
    ),
    Piece(
        "radial-curve", "Radial curve with band and truth",
        "Radial distortion in micrometres over the image radius: as estimated, with a band of one standard deviation, "
        "the true curve dashed, and that of a second model.", "figures.radial_curve", pieces.curve,
    ),
    Piece(
        "distortion-vectors", "Vector field of distortion",
        "Decentering distortion over the format as estimated, on top of the true vectors in grey; the legend gives "
        "the scale of the vectors and their quadratic mean.", "figures.vectors", pieces.decentering,
    ),
    Piece(
        "residual-vectors", "Vector field of residuals",
        "Mean residuals in cells of 20 mm over the format of one camera: a pattern shows what the set of additional "
        "parameters lacks.", "figures.vectors with comparison.mean_residuals", pieces.residuals,
    ),
    Piece(
        "correlations", "Correlations within a set of additional parameters",
        "Heat map of the correlations of 14 parameters with each other, orange negative, purple positive, with "
        "hundredths in the cells.", "figures.correlation_matrix", pieces.correlations,
    ),
    Piece(
        "correlations-exterior", "Additional parameters against the exterior orientation",
        "Heat map of the correlations of four parameters with the six elements of an image; with a second zero at the "
        "centre the radial coefficients go with the flying height.",
        "figures.correlation_rectangle with comparison.ap_exterior_correlations", pieces.with_exterior,
    ),
    Piece(
        "ellipses", "Error ellipses and height bars",
        "Map of the groups with the one-sigma error ellipse of a point and an upright bar for its height error; both "
        "grow towards the edge.", "figures.error_ellipses", pieces.ellipses,
    ),
    Piece(
        "redundancy", "Standard errors against redundancy",
        "Standard errors of four parameters fall as the redundancy grows from a small block to the whole one, on "
        "logarithmic axes.", "figures.falling_errors", pieces.redundancy,
    ),
    Piece(
        "zip", "Zip plot of coverage",
        "Confidence intervals of a height from 512 trials, sorted by how far they are from the truth; those that miss "
        "it are drawn in vermilion, most of them at the top.", "figures.zip_plot", pieces.coverage,
    ),
    Piece(
        "lollipops", "Lollipop plot of biases",
        "Bias of the six elements of an image's orientation in standard deviations, each with its 95 % Monte-Carlo "
        "interval.", "figures.lollipops", pieces.biases,
    ),
    Piece(
        "nested-loop", "Nested-loop plot for many factors",
        "Standard error of a height for 18 combinations of points a group, headings and strips under two sets; steps "
        "below the curves show the levels.", "figures.nested_loop", pieces.many_factors,
    ),
    Piece(
        "published", "Published against simulated",
        "The 18 rows of Table 1 of 1980: published values as diamonds, mean and 95 % range of simulated flights as "
        "dots and bars, for m0, mu_xy and mu_z.", "figures.ranges", pieces.published,
    ),
    Piece(
        "over-a-factor", "A measure over a factor",
        "Correlation of two radial coefficients with a flying height over the place of the second zero, from trials, "
        "with 95 % Monte-Carlo intervals.", "figures.measure_over_factor", pieces.over_a_factor,
    ),
)  # fmt: skip


def page() -> str:
    """The gallery in Markdown."""
    lines = [
        "# Gallery",
        "",
        "Every figure is a function of an axes and data; none computes, none writes. Colours are those of Okabe & Ito,",
        "which people with colour-blindness can tell apart; kinds differ by mark or dash too. The pictures are made by",
        f"`make gallery` from the experiment of 1980, seed {SEED}.",
        "",
    ]
    for piece in PIECES:
        lines += [f"## {piece.title}", "", f"![{piece.says}](gallery/{piece.name}.svg)", ""]
        lines += [piece.says, "", f"`studies.{piece.by}`", ""]
    return "\n".join(lines).rstrip("\n") + "\n"


def drawn(piece: Piece, example: Example) -> str:
    """A piece as SVG."""
    with house_style():
        return svg(piece.draw(example), piece.title, piece.says)


def write(folder: Path) -> list[Path]:
    """Write the gallery into a folder; the files. Raises OSError."""
    make_folder(folder / "gallery")
    example = Example()
    files = {folder / "gallery.md": page()}
    files |= {folder / "gallery" / f"{piece.name}.svg": drawn(piece, example) for piece in PIECES}
    for path, text in files.items():
        write_whole(path, text.encode())
    return list(files)
