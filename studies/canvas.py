"""Blank figures in the house style, and files from them: no pyplot, no date, no random ids, so identical bytes every
time.

Colours are those of Okabe & Ito 2008, which people with colour-blindness can tell apart.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLACK, ORANGE, SKY, GREEN, BLUE, VERMILION, PURPLE = (
    *("#000000", "#e69f00", "#56b4e9", "#009e73", "#0072b2", "#d55e00", "#cc79a7"),
)
GREY = "#9a9a9a"
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY)
MARKERS = ("o", "s", "^", "D", "v", "P")
STYLE: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.titlesize": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.grid": False,
    "grid.color": "#d8d8d8",
    "grid.linewidth": 0.5,
    "legend.frameon": False,
    "lines.linewidth": 1.4,
    "svg.hashsalt": "simfield",
    "svg.fonttype": "path",
}
RASTER_DPI = 150
MILLIMETRE = 1.0 / 25.4


@contextmanager
def house_style() -> Iterator[None]:
    """Inside, figures look as ours do, whatever the user's own settings are. Draw and save inside."""
    import matplotlib

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        with matplotlib.rc_context(STYLE):
            yield


def new_figure(width_mm: float, height_mm: float) -> Figure:
    """An empty figure that arranges its axes by itself."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width_mm * MILLIMETRE, height_mm * MILLIMETRE), layout="constrained")


def save(figure: Figure, path: Path) -> list[Path]:
    """Write path.svg and path.png; the files."""
    vector, raster = path.with_name(path.name + ".svg"), path.with_name(path.name + ".png")
    figure.savefig(vector, metadata={"Date": None, "Creator": None})
    figure.savefig(raster, metadata={"Software": None}, dpi=RASTER_DPI)
    return [vector, raster]
