"""SVG files put into a page: only what a drawing of ours needs is let through, and ids of two figures never meet."""

from __future__ import annotations

import re
from dataclasses import dataclass
from html import escape
from xml.etree import ElementTree

SVG = "{http://www.w3.org/2000/svg}"
LINK = "{http://www.w3.org/1999/xlink}href"
MOST_BYTES = 20 << 20
DRAWN = {"svg", "g", "defs", "path", "use", "clipPath", "rect", "image"}
LEFT_OUT = {"metadata", "style", "title", "desc"}
"""title and desc are written anew; the one rule of the style stands in the page"""
ATTRIBUTES = {"id", "d", "style", "transform", "x", "y", "width", "height", "viewBox", "clip-path"}
IGNORED = {"version", "role", "aria-label", "preserveAspectRatio"}
STYLE = re.compile(r"[-\w\s:;.,#%()]*\Z")
PICTURE = re.compile(r"data:image/png;base64,[A-Za-z0-9+/=\s]+\Z")
LENGTH = re.compile(r"(\d+(?:\.\d+)?)pt\Z")
DECIMALS = re.compile(r"-?\d+\.\d{3,}")
GLYPHS = re.compile(r"scale\((\d*\.?\d+) -")
"""a line of text stands upside down, scaled from letters of LETTER_PT"""
LETTER_PT = 100.0


class DrawingError(ValueError):
    """What was read is no figure of ours; one line."""


@dataclass(frozen=True)
class Drawing:
    """An SVG for a page: width and smallest letters on paper (0: none), title, what it shows, the element."""

    width_pt: float
    letter_pt: float
    title: str
    says: str
    markup: str


def inline(text: str, number: int, title: str = "") -> Drawing:
    """A figure for a page, its ids prefixed with its number; title is used where the file has none.

    Raises DrawingError for anything that this project's figures do not contain: scripts, links, foreign pictures.
    """
    if len(text) > MOST_BYTES or "<!ENTITY" in text:
        raise DrawingError("too large, or with entities of its own")
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise DrawingError(f"no SVG: {error}") from None
    size = LENGTH.match(root.get("width", ""))
    if root.tag != f"{SVG}svg" or size is None:
        raise DrawingError("no SVG of matplotlib's")
    title = _text(root, "title") or title or "Figure"
    says = _text(root, "desc")
    told = f'<title>{escape(title)}</title><desc id="f{number}-says">{escape(says)}</desc>'
    parts = [_written(child, f"f{number}-") for child in root]
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{escape(root.get("viewBox", ""))}" role="img"'
    head += f' aria-label="{escape(title)}" aria-describedby="f{number}-says">'
    return Drawing(float(size[1]), _smallest_letters(root), title, says, f"{head}{told}{''.join(parts)}</svg>")


def _smallest_letters(root: ElementTree.Element) -> float:
    scales = (GLYPHS.search(element.get("transform", "")) for element in root.iter())
    return min((LETTER_PT * float(scale[1]) for scale in scales if scale), default=0.0)


def _text(root: ElementTree.Element, name: str) -> str:
    return " ".join((root.findtext(f"{SVG}{name}") or "").split())


def _written(element: ElementTree.Element, prefix: str) -> str:
    """An element and all below it as text."""
    name = element.tag.removeprefix(SVG)
    if name in LEFT_OUT:
        return ""
    if name not in DRAWN:
        raise DrawingError(f"<{name[:40]}> is in it, which no figure of ours has")
    attributes = "".join(_attribute(name, key, value, prefix) for key, value in element.items())
    inner = "".join(_written(child, prefix) for child in element)
    return f"<{name}{attributes}>{inner}</{name}>" if inner else f"<{name}{attributes}/>"


def _attribute(element: str, key: str, value: str, prefix: str) -> str:
    if key in IGNORED:
        return ""
    if key == "id":
        return f' id="{escape(prefix + value)}"'
    if key == LINK:
        if value.startswith("#"):
            return f' href="#{escape(prefix + value[1:])}"'
        if element == "image" and PICTURE.match(value):
            return f' href="{"".join(value.split())}"'
        raise DrawingError(f"a link to {value[:40]!r} is in it")
    if key not in ATTRIBUTES or (key == "style" and not STYLE.match(value)):
        raise DrawingError(f"the attribute {key[:40]} is in it, which no figure of ours has")
    if key == "d":
        value = DECIMALS.sub(_two_decimals, " ".join(value.split()))
    if "url(" in value and value.count("url(") != value.count("url(#"):
        raise DrawingError("a link to something outside is in it")
    return f' {key}="{escape(value.replace("url(#", f"url(#{prefix}"))}"'


def _two_decimals(found: re.Match[str]) -> str:
    """A coordinate of a path in hundredths of a point, which nobody can see."""
    return f"{float(found[0]):.2f}".rstrip("0").removesuffix(".")
