"""The built documentation: no warnings, nothing from another host, every public name and command in the reference."""

from __future__ import annotations

import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

import adjust
import simfield
from adjust import ap_models
from studies.commands.program import main

TOP = Path(__file__).parents[1]
FETCHING = {
    "script": "src",
    "link": "href",
    "img": "src",
    "iframe": "src",
    "source": "src",
    "audio": "src",
    "video": "src",
    "object": "data",
    "embed": "src",
    "use": "href",
    "image": "href",
}
"""elements that make a browser fetch something, and by which attribute"""
ELSEWHERE = re.compile(r"\s*(?:[a-z]+:)?//", re.IGNORECASE)
IN_STYLE = re.compile(r"(?:url\(|@import)\s*[\"']?(?:[a-z]+:)?//[^\"')\s]+", re.IGNORECASE)


class Fetched(HTMLParser):
    """What a page makes a browser fetch from another host."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name == FETCHING.get(tag) and ELSEWHERE.match(value or ""):
                self.found.append(f"<{tag} {name}={value}>")
            if name == "srcset" and re.search(r"(?:[a-z]+:)?//", value or ""):
                self.found.append(f"<{tag} srcset={value}>")


def fetched_from_elsewhere(text: str) -> list[str]:
    page = Fetched()
    page.feed(text)
    return page.found + IN_STYLE.findall(text)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("docs")
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-b", "html", "-d", str(out / "doctrees")]
    done = subprocess.run([*command, str(TOP / "docs"), str(out / "html")], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out / "html"


@pytest.mark.parametrize(
    "line",
    [
        '<script src="https://cdn.example/mathjax.js"></script>',
        '<link rel="stylesheet" href="//fonts.example/css">',
        '<img src="http://badges.example/build.svg">',
        "<style>@font-face { src: url(https://fonts.example/a.woff2) }</style>",
        '<style>@import "https://fonts.example/css";</style>',
    ],
)
def test_what_comes_from_another_host_is_seen(line: str) -> None:
    assert len(fetched_from_elsewhere(line)) == 1


def test_a_link_to_another_host_is_no_fetch() -> None:
    assert fetched_from_elsewhere('<a href="https://semver.org/">x</a><img src="_static/a.svg">') == []


@pytest.mark.slow
def test_no_page_fetches_anything_from_another_host(built: Path) -> None:
    pages = [*built.rglob("*.html"), *built.rglob("*.css")]
    assert len(pages) > 30
    found = {page.name: fetched_from_elsewhere(page.read_text(encoding="utf-8")) for page in pages}
    assert {name: lines for name, lines in found.items() if lines} == {}


@pytest.mark.slow
def test_every_public_name_is_in_the_reference(built: Path) -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in (built / "reference").glob("*.html"))
    public = {f"{module.__name__}.{name}" for module in (simfield, adjust, ap_models) for name in module.__all__}
    not_described = {
        f"{module.__name__}.{name}"
        for module in (simfield, adjust, ap_models)
        for name in module.__all__
        if not callable(getattr(module, name))
    }
    """mappings, numbers and modules, which their pages show"""
    public -= {"adjust.ApModel"}  # described as adjust.ap_models.ApModel
    assert {name for name in public - not_described if f'id="{name}"' not in text} == set()


@pytest.mark.slow
def test_every_command_and_every_set_is_in_the_reference(built: Path) -> None:
    commands = (built / "reference/command-line.html").read_text(encoding="utf-8")
    assert [name for name in main.commands if f'id="simfield-{name}"' not in commands] == []
    sets = (built / "reference/ap-models.html").read_text(encoding="utf-8")
    assert [name for name in ap_models.names() if f'id="set-{name}"' not in sets] == []


@pytest.mark.slow
def test_formulas_are_markup_of_the_page_itself(built: Path) -> None:
    page = (built / "explanation/chord-iterations.html").read_text(encoding="utf-8")
    assert page.count("<math ") > 20
    assert r"\frac" not in page
