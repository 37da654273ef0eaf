"""Markdown as HTML: headings, paragraphs, lists, tables, code, and figures; no links, and no HTML from the text."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from typing import Any

from studies.texts.inline_svg import Drawing
from studies.texts.markdown_text import unbroken

TABLE = '<div class="table" role="region" aria-label="table" tabindex="0"><table>\n'
PAGE_WIDTH_PT = 360.0
"""a figure that is wider scrolls sideways on a phone instead of becoming too small to read"""
PHONE_WIDTH_PT = 268.0
"""what a phone 390 px wide leaves for a figure"""
LEAST_LETTER_PT = 6.9
"""9.2 px: a figure is never drawn so narrow that its smallest letters are smaller"""
NUMBER = re.compile(r"(?=.*\d)[-+−?]?[\d.?]+(?:e[-+]?\d+)?(?: [±/] [-\de.?–]+| \([-\d.–]+\))?\Z|–\Z")
"""a cell of a column of numbers: 5, -0.2, 5.70 ± 0.02, 6.4 / 6.59, 41 (32–52), a dash"""
OPTION = re.compile(r"(?<!\S)--\w[-\w]*")
Figure = Callable[[str, str], Drawing]
"""the figure of a file name; the second argument is the text that stands for it"""


@dataclass(frozen=True)
class Page:
    """The title, (anchor, text) of each section, and the body as HTML that is safe to put into a page."""

    title: str
    sections: tuple[tuple[str, str], ...]
    body: str


def converted(text: str, figure: Figure) -> Page:
    """A page from Markdown. Whatever figure raises is raised."""
    from markdown_it import MarkdownIt

    reader = MarkdownIt("commonmark", {"html": False}).enable("table")
    reader.disable(["link", "autolink", "reference", "html_inline", "html_block"])
    reader.add_render_rule("image", _figure_rule(figure))
    reader.add_render_rule("fence", _code)
    reader.add_render_rule("code_block", _code)
    reader.add_render_rule("table_open", _constant(TABLE))
    reader.add_render_rule("table_close", _constant("</table></div>\n"))
    title, tokens = _without_title(reader.parse(text))
    sections = tuple(_anchored(tokens))
    _unwrap_figures(tokens)
    _align_numbers(tokens)
    _break_at_good_places(tokens)
    body = reader.renderer.render(tokens, reader.options, {})
    return Page(title, sections, body.replace("<th ", '<th scope="col" ').replace("<th>", '<th scope="col">'))


def _constant(html: str) -> Any:
    return lambda renderer, tokens, index, options, env: html


def _figure_rule(figure: Figure) -> Any:
    def rule(renderer: Any, tokens: Sequence[Any], index: int, options: Any, env: Any) -> str:
        token = tokens[index]
        drawing = figure(str(token.attrs.get("src", "")), str(token.content))
        least_pt = drawing.width_pt * LEAST_LETTER_PT / drawing.letter_pt if drawing.letter_pt else 0.0
        kind = "wide" if drawing.width_pt > PAGE_WIDTH_PT else "narrow"
        if max(least_pt, drawing.width_pt if kind == "wide" else 0.0) > PHONE_WIDTH_PT:
            kind += " scrolls"
        title, says = (escape(unbroken(text)) for text in (drawing.title, drawing.says))
        caption = f"<figcaption><b>{title}.</b> {says}</figcaption>"
        size = f'style="--natural:{drawing.width_pt:g}pt;--least:{least_pt:.0f}pt"'
        return f'<figure class="{kind}" {size}><div class="drawing">{drawing.markup}</div>{caption}</figure>'

    return rule


def _code(renderer: Any, tokens: Sequence[Any], index: int, options: Any, env: Any) -> str:
    """A block of code whose options are not torn apart at their dashes where a line is too long."""
    text = OPTION.sub(r"<span>\g<0></span>", escape(tokens[index].content, quote=False))
    return f"<pre><code>{text}</code></pre>\n"


def _align_numbers(tokens: Sequence[Any]) -> None:
    """Set columns flush right that hold numbers alone."""
    columns: dict[int, list[tuple[Any, str]]] = {}
    column = 0
    for token, following in zip(tokens, [*tokens[1:], None], strict=True):
        if token.type in ("th_open", "td_open"):
            columns.setdefault(column, []).append((token, _plain(following)))
        column = 0 if token.type == "tr_open" else column + (token.type in ("th_open", "td_open"))
        if token.type == "table_close":
            for cells in columns.values():
                if len(cells) > 1 and all(NUMBER.match(text) for _, text in cells[1:]):
                    for cell, _ in cells:
                        cell.attrSet("style", "text-align:right")
            columns = {}


def _break_at_good_places(tokens: Sequence[Any]) -> None:
    """No line ends between a number and its unit; the heading of a column may break behind an underscore."""
    for before, token in pairwise(tokens):
        for child in token.children or ():
            if child.type == "text":
                child.content = unbroken(child.content)
                if before.type == "th_open":
                    child.type, child.content = "html_inline", escape(child.content).replace("_", "_<wbr>")


def _without_title(tokens: list[Any]) -> tuple[str, list[Any]]:
    """The heading of the first level that opens the page, and the rest."""
    if len(tokens) >= 3 and tokens[0].tag == "h1":
        return _plain(tokens[1]), tokens[3:]
    return "Report", tokens


def _anchored(tokens: Sequence[Any]) -> Iterator[tuple[str, str]]:
    """Give every second-level heading an anchor; anchors and texts."""
    for token, following in pairwise(tokens):
        if token.type == "heading_open" and token.tag == "h2":
            text = _plain(following)
            anchor = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "section"
            token.attrSet("id", f"{anchor}-{token.map[0] if token.map else 0}")
            yield token.attrs["id"], text


def _plain(inline: Any) -> str:
    return "".join(child.content for child in inline.children or () if child.type in ("text", "code_inline"))


def _unwrap_figures(tokens: Sequence[Any]) -> None:
    """A paragraph that holds figures alone is none."""
    for before, token, behind in zip(tokens, tokens[1:], tokens[2:], strict=False):
        children = token.children or ()
        if before.type == "paragraph_open" and any(child.type == "image" for child in children):
            before.hidden = behind.hidden = all(child.type in ("image", "softbreak") for child in children)
