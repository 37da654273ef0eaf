"""Blank figures in the house style, and files from them: no pyplot, no date, no random ids, so identical bytes every
time.

Colours are those of Okabe & Ito 2008, which people with colour-blindness can tell apart.
"""

from __future__ import annotations

import io
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from html import escape
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
    "text.parse_math": False,  # a name with two dollar signs is a name, not a formula
}
RASTER_DPI = 150
MILLIMETRE = 1.0 / 25.4
MOST_LABEL, MOST_ALTERNATIVE = 60, 600
"""characters of a label, and of an alternative text"""


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


def save(figure: Figure, path: Path, title: str = "", says: str = "") -> list[Path]:
    """Write path.svg, with title and says as alternative text, and path.png; the files."""
    vector, raster = path.with_name(path.name + ".svg"), path.with_name(path.name + ".png")
    vector.write_text(svg(figure, title, says), encoding="utf-8")
    with _missing_glyphs_as_boxes():
        figure.savefig(raster, metadata={"Software": None}, dpi=RASTER_DPI)
    return [vector, raster]


def svg(figure: Figure, title: str = "", says: str = "") -> str:
    """The figure as an SVG file; who cannot see it is told the title, and says describes what it shows."""
    stream = io.BytesIO()
    with _missing_glyphs_as_boxes():
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue().decode()
    if not title:
        return text
    label = escape(literal(title, MOST_ALTERNATIVE))
    start = text.index("<svg ")
    end = text.index(">", start)
    told = f"\n <title>{label}</title>\n <desc>{escape(literal(says, MOST_ALTERNATIVE))}</desc>"
    return f'{text[:end]} role="img" aria-label="{label}">{told}{text[end + 1 :]}'


def literal(text: str, most: int = MOST_LABEL) -> str:
    """A user's text as a label: one line, no control characters, not endless."""
    line = " ".join(text.split())
    shown = "".join(c if c.isprintable() else "\ufffd" for c in line)
    if shown.startswith("_"):  # matplotlib leaves such labels out of legends
        shown = f" {shown}"
    return shown if len(shown) <= most else shown[: most - 1] + "…"


@contextmanager
def _missing_glyphs_as_boxes() -> Iterator[None]:
    """The font shows a box for a character that it has not; that is no reason for a warning."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        warnings.filterwarnings("ignore", message="Matplotlib currently does not support")
        yield
