"""Markdown as HTML: headings, paragraphs, lists, tables, code, and figures; no links, and no HTML from the text."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from typing import Any

from studies.inline_svg import Drawing

TABLE = '<div class="table" role="region" aria-label="table" tabindex="0"><table>\n'
PAGE_WIDTH_PT = 360.0
"""a figure that is wider scrolls sideways on a phone instead of becoming too small to read"""
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
    reader.add_render_rule("table_open", _constant(TABLE))
    reader.add_render_rule("table_close", _constant("</table></div>\n"))
    title, tokens = _without_title(reader.parse(text))
    sections = tuple(_anchored(tokens))
    _unwrap_figures(tokens)
    body = reader.renderer.render(tokens, reader.options, {})
    return Page(title, sections, body.replace("<th ", '<th scope="col" ').replace("<th>", '<th scope="col">'))


def _constant(html: str) -> Any:
    return lambda renderer, tokens, index, options, env: html


def _figure_rule(figure: Figure) -> Any:
    def rule(renderer: Any, tokens: Sequence[Any], index: int, options: Any, env: Any) -> str:
        token = tokens[index]
        drawing = figure(str(token.attrs.get("src", "")), str(token.content))
        kind = "wide" if drawing.width_pt > PAGE_WIDTH_PT else "narrow"
        caption = f"<figcaption><b>{escape(drawing.title)}.</b> {escape(drawing.says)}</figcaption>"
        size = f'style="--natural:{drawing.width_pt:g}pt"'
        return f'<figure class="{kind}" {size}><div class="drawing">{drawing.markup}</div>{caption}</figure>'

    return rule


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
