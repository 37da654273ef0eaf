"""The README tells the truth: its tour and its questions run, its public names exist."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.document_session import Piece, Session
from tests.draw_house import drawn, page
from tests.house import House
from tests.test_documents import SHORTENED

TOP = Path(__file__).parents[1]
OUTPUT = re.compile(r"^```output\n(.*?)^```", re.DOTALL | re.MULTILINE)
README = (TOP / "README.md").read_text(encoding="utf-8")
PYTHON = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
QUESTION = re.compile(r"^\| [^|]+\? \| `(simfield [^`]+)` \| \[", re.MULTILINE)
MOST_LINES = 150


def section(title: str) -> str:
    return README.split(f"## {title}\n", 1)[1].split("\n## ", 1)[0]


TOURS = PYTHON.findall(section("A tour"))


def test_there_is_one_tour_of_readable_length() -> None:
    assert len(TOURS) == 1
    assert len(TOURS[0].splitlines()) <= 25


def test_the_tour_runs(tmp_path: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", TOURS[0]], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert run.returncode == 0, run.stderr
    assert run.stdout == OUTPUT.findall(section("A tour"))[0]


def test_it_is_short_enough_to_be_read() -> None:
    assert README.count("\n") < MOST_LINES


def test_the_public_names_can_be_imported() -> None:
    imports = re.findall(r"^from (\w+) import (.+)$", section("Public names"), re.MULTILINE)
    assert [module for module, _ in imports] == ["simfield", "adjust"]
    for module, names in imports:
        for name in names.split(", "):
            assert hasattr(importlib.import_module(module), name), f"{module}.{name}"


def test_the_commands_of_the_readme_exist() -> None:
    from studies.commands.program import main

    named = set(re.findall(r"(?:^|`)simfield ([a-z]+)", README.split("\n## ", 1)[1], re.MULTILINE))
    assert named >= {"simulate", "adjust", "run", "reduce"}
    assert named <= set(main.commands)


def test_the_links_of_the_readme_lead_somewhere() -> None:
    links = [link for link in re.findall(r"\]\(([^)]+)\)", README) if "://" not in link]
    assert links
    assert [link for link in links if not (TOP / link).exists()] == []


def test_the_house_is_drawn_as_it_stands() -> None:
    house = House.standing()
    assert (TOP / "docs/house.md").read_text(encoding="utf-8") == page(house)
    assert (TOP / "docs/figures/house.svg").read_text(encoding="utf-8") == drawn(house)


@pytest.mark.slow
def test_every_question_has_its_answer(tmp_path: Path) -> None:
    """The commands of the table, one after the other in an empty directory; those of minutes with fewer trials."""
    commands = QUESTION.findall(section("What you can ask"))
    assert len(commands) >= 12
    lines = "".join(f"{command}\n" for command in commands)
    Session(tmp_path, [Piece("README.md", 1, "sh", lines)], [], SHORTENED).run()
    assert {"block", "protocol", "ap-models", "report.html", "raw", "reduced", "results"} <= {
        path.name for path in tmp_path.iterdir()
    }
