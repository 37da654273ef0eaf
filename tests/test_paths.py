"""Every path and every dotted name of ours that a document, a docstring, a message or a study file names is there."""

from __future__ import annotations

import re
import subprocess
from functools import cache

from tests.house import PACKAGES, TOP, House

ENDINGS = (".py", ".pyi", ".md", ".toml", ".html", ".css", ".csv", ".json", ".yaml", "Makefile", ".ci/run")
FOLDERS = ("simfield", "adjust", "studies", "tests", "docs", "benchmarks", "results")
PATH = re.compile(rf"(?<![\w/.*-])(?:{'|'.join(FOLDERS)})(?:/[\w*-]+)*/[\w*.-]*\w\*?")
DOTTED = re.compile(rf"(?<![\w/.@-])(?:{'|'.join(PACKAGES)})(?:\.[A-Za-z_]\w*)+(?![\w/])")
NO_NAMES = re.compile(r"\.(toml|py|md|csv|json|html|css)$")
MADE_LATER = (
    "docs/_build",
    "results/mauelshagen-1980-twin",
    "results/detection",
    "results/ziemann-1982",
    "results/error-budget",
)
"""made by a command, and not committed in every case"""
EXAMPLES = ("tests/test_paths.py", "tests/test_house.py", "tests/contract/test_doors.py")
"""texts whose names are made up"""


def texts() -> dict[str, str]:
    listed = subprocess.run(["git", "ls-files"], cwd=TOP, check=True, capture_output=True, text=True).stdout.split()
    return {
        path: (TOP / path).read_text(encoding="utf-8")
        for path in listed
        if path.endswith(ENDINGS) and path not in EXAMPLES and (TOP / path).is_file()
    }


def test_every_path_exists() -> None:
    lost, seen = [], 0
    for place, text in texts().items():
        for found in set(PATH.findall(text)):
            seen += 1
            if not found.startswith(MADE_LATER) and not found.split("/")[-1].isupper() and not any(TOP.glob(found)):
                lost.append(f"{place}: {found}")
    assert seen > 100
    assert sorted(lost) == []


@cache
def house() -> House:
    return House.standing()


def _is_there(name: str) -> bool:
    """Whether a dotted name is a module, something in one, or a member of something in one."""
    parts = name.split(".")
    for cut in range(len(parts), 0, -1):
        module = ".".join(parts[:cut])
        if module not in house().modules:
            continue
        rest = parts[cut:]
        if not rest:
            return True
        place = house().file_of(module, rest[0]) or house().modules[module]
        if (module, rest[0]) in house().offered:
            return True
        text = house().texts[place]
        return bool(
            re.search(rf"^(\s*(def|class) {rest[0]}\b|{rest[0]}\b.* = |{rest[0]}: |from .*\b{rest[0]}\b)", text, re.M)
        )
    return False


def test_every_dotted_name_exists() -> None:
    lost, seen = [], 0
    for place, text in texts().items():
        for found in set(DOTTED.findall(text)):
            if NO_NAMES.search(found):
                continue
            seen += 1
            if not _is_there(found):
                lost.append(f"{place}: {found}")
    assert seen > 100
    assert sorted(lost) == []
