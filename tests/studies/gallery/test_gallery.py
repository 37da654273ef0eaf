"""The gallery shows what the code draws: its page is made from the pieces, its pictures are there and told."""

import importlib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from studies.gallery.gallery import PIECES, drawn, page
from studies.gallery.pieces import Example

DOCS = Path(__file__).parents[3] / "docs"
SVG = "{http://www.w3.org/2000/svg}"
QUICK = ("plan", "radii", "ellipses", "residual-vectors")
"""pieces that need one adjustment at most"""


def test_the_page_in_the_documents_is_the_one_that_is_made():
    assert (DOCS / "gallery.md").read_text(encoding="utf-8") == page()
    assert sorted(p.stem for p in (DOCS / "gallery").iterdir()) == sorted(piece.name for piece in PIECES)


@pytest.mark.parametrize("piece", PIECES, ids=lambda piece: piece.name)
def test_every_picture_says_what_it_shows(piece):
    root = ElementTree.parse(DOCS / "gallery" / f"{piece.name}.svg").getroot()
    assert root.get("role") == "img"
    assert root.get("aria-label") == piece.title
    assert root.findtext(f"{SVG}title") == piece.title
    assert root.findtext(f"{SVG}desc") == piece.says


@pytest.mark.parametrize("piece", PIECES, ids=lambda piece: piece.name)
def test_every_function_that_is_named_exists(piece):
    for name in piece.by.split(" with "):
        module, function = name.split(".")
        assert callable(getattr(importlib.import_module(f"studies.{module}"), function))


def test_the_same_bytes_twice():
    chosen = [piece for piece in PIECES if piece.name in QUICK]
    first, second = ([drawn(piece, Example()) for piece in chosen] for _ in range(2))
    assert first == second


@pytest.mark.slow
def test_every_piece_is_drawn():
    example = Example()
    for piece in PIECES:
        assert len(drawn(piece, example)) > 10_000
