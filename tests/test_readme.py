"""The README tells the truth: its tour runs, its map is the tree, its commands and public names exist."""

from __future__ import annotations

import importlib
import re
import subprocess
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]
README = (TOP / "README.md").read_text(encoding="utf-8")
PYTHON = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
PACKAGES = ("simfield", "adjust", "studies")


def section(title: str) -> str:
    return README.split(f"## {title}\n", 1)[1].split("\n## ", 1)[0]


TOURS = PYTHON.findall(section("A tour"))


def mapped_modules() -> list[str]:
    """The modules that the map names: a line `package/` opens a package, an indented `module.py` is one of it."""
    package, modules = "", []
    for line in section("The house").splitlines():
        if found := re.match(r" {4}([a-z]\S*/)", line):
            package = found[1]
        elif found := re.match(r" {6}([a-z]\S*\.py) ", line):
            modules.append(package + found[1])
    return modules


def test_there_is_one_tour_of_readable_length() -> None:
    assert len(TOURS) == 1
    assert len(TOURS[0].splitlines()) <= 36


def test_the_tour_runs(tmp_path: Path) -> None:
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", TOURS[0]], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert run.returncode == 0, run.stderr
    printed = run.stdout.splitlines()
    assert printed[0] == "39 images, 123 points, 3313 image points"
    assert [line.split()[0] for line in printed[1:5]] == ["none", "optical", "torlegard", "brown14"]


def test_every_module_on_the_map_exists_once() -> None:
    modules = mapped_modules()
    assert modules
    assert len(set(modules)) == len(modules)
    assert [module for module in modules if not (TOP / module).is_file()] == []


@pytest.mark.parametrize("package", PACKAGES)
def test_every_module_is_on_the_map(package: str) -> None:
    on_disk = {f.relative_to(TOP).as_posix() for f in (TOP / package).rglob("*.py") if f.name != "__init__.py"}
    assert sorted(on_disk - set(mapped_modules())) == []


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
