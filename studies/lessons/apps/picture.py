"""A picture of a lesson: an SVG with its alternative text, that marimo and Jupyter show as it is."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock
from typing import TYPE_CHECKING

from studies.figures import house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_ONE_AT_A_TIME = Lock()
"""matplotlib's settings belong to the process, and every visitor has a thread of the same process"""


LEAST_WIDTH = "40rem"
"""narrower screens scroll, so that letters stay readable"""
SCROLLING = (
    "overflow-x:auto;background:"
    "linear-gradient(to left,#fff 40%,transparent) right/3rem 110% no-repeat local,"
    "linear-gradient(to left,rgb(0 0 0/0.2),transparent) right/0.8rem 100% no-repeat scroll"
)
"""a shadow at the right edge as long as there is more to see; the picture must let it through"""


@dataclass(frozen=True)
class Picture:
    """An SVG and the words for those who do not see it."""

    svg: bytes
    alternative: str

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.svg).decode("ascii")
        words = html.escape(self.alternative, quote=True)
        style = f"width:100%;min-width:{LEAST_WIDTH};mix-blend-mode:multiply"
        image = f'<img alt="{words}" style="{style}" src="data:image/svg+xml;base64,{data}">'
        return f'<div style="{SCROLLING}">{image}</div>'


def picture(width_mm: float, height_mm: float, alternative: str, draw: Callable[[Figure], None]) -> Picture:
    """Draw on an empty figure of that size, in the house style."""
    written = io.BytesIO()
    with _ONE_AT_A_TIME, house_style():
        figure = new_figure(width_mm, height_mm)
        draw(figure)
        figure.savefig(written, format="svg", metadata={"Date": None, "Creator": None})
    return Picture(written.getvalue(), alternative)
