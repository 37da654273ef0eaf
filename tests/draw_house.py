"""The house in one drawing and one page: `make house` writes docs/house.md and docs/figures/house.svg from the
source.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator, Mapping
from html import escape
from pathlib import Path

from tests.house import TOP, House, room_of
from tests.test_house import AGREEMENT, READABLE

MOTTOS = {
    "simfield": "a world with known truth",
    "adjust": "from a block to estimates",
    "studies": "questions put many times",
}
INK, FAINT = "#1b2733", "#55677a"
COLOURS = {"simfield": "#dcefdc", "adjust": "#d7e8f5", "studies": "#f7e6c8"}
COLUMN, MARGIN, GAP, HEAD, BOX = 400, 16, 8, 56, 50
"""pixels: the width of a package, the space around all and between boxes, the heads, the height of a box"""
LETTER = 5.9
"""pixels that a letter of the small text takes, on average"""


def layers(arrows: Mapping[str, set[str]], rooms: list[str]) -> list[list[str]]:
    """Rooms of one package in rows: a room stands above everything that it needs."""
    depth: dict[str, int] = {}

    def deep(room: str) -> int:
        if room not in depth:
            depth[room] = 1 + max((deep(other) for other in arrows[room] if other in rooms), default=-1)
        return depth[room]

    rows: list[list[str]] = [[] for _ in range(1 + max(map(deep, rooms)))]
    for room in rooms:
        rows[depth[room]].append(room)
    return rows[::-1]


def drawn(house: House) -> str:
    """The drawing as SVG, on a card of its own, so that it looks the same on a white and on a dark page."""
    columns = {p: layers(house.room_arrows, [r for r in house.room_arrows if r.startswith(f"{p}/")]) for p in MOTTOS}
    tallest = max(map(len, columns.values()))
    height = 2 * MARGIN + HEAD + tallest * (BOX + GAP) + GAP
    width = len(columns) * (COLUMN + MARGIN) + MARGIN
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="Verdana, DejaVu Sans, sans-serif" role="img" aria-label="The rooms of the three packages">',
        f'<rect width="{width}" height="{height}" rx="14" fill="#ffffff"/>',
    ]
    for number, (package, rows) in enumerate(columns.items()):
        left = MARGIN + number * (COLUMN + MARGIN)
        lines += [
            f'<rect x="{left}" y="{MARGIN}" width="{COLUMN}" height="{height - 2 * MARGIN}" rx="10" '
            f'fill="{COLOURS[package]}"/>',
            _text(left + 14, MARGIN + 26, package, 18, INK, "bold"),
            _text(left + 14, MARGIN + 45, MOTTOS[package], 12, FAINT),
        ]
        ground = height - MARGIN - GAP - len(rows) * (BOX + GAP)
        for place, row in enumerate(rows):
            box = (COLUMN - GAP * (len(row) + 1)) / len(row)
            for seat, room in enumerate(row):
                x, y = left + GAP + seat * (box + GAP), ground + GAP + place * (BOX + GAP)
                lines += _box(house, room, x, y, box)
    return "\n".join([*lines, "</svg>", ""])


def _box(house: House, room: str, x: float, y: float, width: float) -> Iterator[str]:
    name = room.split("/")[1]
    yield f'<rect x="{x:.1f}" y="{y}" width="{width:.1f}" height="{BOX}" rx="6" fill="#ffffff" stroke="{INK}"/>'
    yield _text(x + width / 2, y + 20, name, 13 if width > 90 else 11, INK, "bold", "middle")
    sign = house.sign(room)
    ends = [found.start() for found in re.finditer(r"[:;,.] |[.]$", sign)]
    fitting = [sign[:end] for end in ends if LETTER * end < width - 8]
    if fitting:
        small = fitting[-1]
    else:
        inside = sum(path.startswith(f"{room}/") and not path.endswith("__init__.py") for path in house.files)
        small = f"{inside} modules" if inside else "a module"
    yield _text(x + width / 2, y + 37, small, 10.5, FAINT, "normal", "middle")


def _text(
    x: float, y: float, words: str, size: float, colour: str, weight: str = "normal", anchor: str = "start"
) -> str:
    return (
        f'<text x="{x:.1f}" y="{y}" font-size="{size}" fill="{colour}" font-weight="{weight}" '
        f'text-anchor="{anchor}">{escape(words)}</text>'
    )


def page(house: House) -> str:
    """docs/house.md: every room with its door sign and its modules, and the compiled twins."""
    lines = [
        "# The house",
        "",
        "Made from the source by `make house`; a test holds it current. How to build in it:",
        "[development](development.md). A room knows only rooms below it, `studies` all of `adjust` and `simfield`;",
        "`adjust` knows `block` and `numerics` of `simfield` and nothing else.",
        "",
        "![Rooms of the three packages, each above what it needs](figures/house.svg)",
        "",
    ]
    for package in ("simfield", "adjust", "studies"):
        lines += [f"## {package}", "", house.sign(package), ""]
        lines += ["| room | what it is for | modules |", "|---|---|---|"]
        for room in sorted(r for r in house.room_arrows if r.startswith(f"{package}/")):
            lines.append(f"| `{room.split('/')[1]}` | {_cell(house.sign(room))} | {_inside(house, room)} |")
        lines.append("")
    lines += ["## Compiled twins", "", "| compiled | readable form | they agree |", "|---|---|---|"]
    for path in sorted(p for p in house.files if p.endswith("_compiled.py")):
        said = ast.get_docstring(house.files[path]) or ""
        form, test = READABLE.search(said), AGREEMENT.search(said)
        lines.append(f"| `{path}` | `{form[1] if form else '?'}` | `{test[1] if test else '?'}` |")
    return "\n".join([*lines, ""])


def _inside(house: House, room: str) -> str:
    names = []
    for path in house.files:
        if room_of(path) == room and path.startswith(f"{room}/") and not path.endswith("__init__.py"):
            names.append(path.removeprefix(f"{room}/").removesuffix(".py"))
    return ", ".join(f"`{name}`" for name in sorted(names))


def _cell(text: str) -> str:
    return text.replace("|", r"\|")


def write(docs: Path) -> None:
    house = House.standing()
    (docs / "house.md").write_text(page(house), encoding="utf-8")
    (docs / "figures/house.svg").write_text(drawn(house), encoding="utf-8")


if __name__ == "__main__":
    write(Path(sys.argv[1]) if len(sys.argv) > 1 else TOP / "docs")
