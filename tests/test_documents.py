"""What the documents say is executed: every python block, and the smallest block folder of the conventions."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from adjust import adjust_block
from simfield.block_folder import COLUMNS, read_block, write_block

TOP = Path(__file__).parents[1]
CONVENTIONS = (TOP / "docs/conventions.md").read_text(encoding="utf-8")
PYTHON_BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("number", range(len(PYTHON_BLOCK.findall(CONVENTIONS))))
def test_the_worked_examples_of_the_conventions_hold(number: int) -> None:
    exec(compile(PYTHON_BLOCK.findall(CONVENTIONS)[number], f"docs/conventions.md, block {number}", "exec"), {})


@pytest.mark.parametrize("table", COLUMNS)
def test_every_column_is_explained(table: str) -> None:
    section = CONVENTIONS.split(f"### {table}.csv\n")[1].split("\n### ")[0]
    named = [name for row in re.findall(r"^\| ([^|]+) \|", section, re.MULTILINE)[1:] for name in row.split(", ")]
    assert named == list(COLUMNS[table])


def test_the_smallest_folder_can_be_adjusted_and_is_written_as_it_stands(tmp_path: Path) -> None:
    listing = CONVENTIONS.split("### The smallest folder\n")[1]
    for name, rows in re.findall(r"^    (\w+\.csv) +(\S+\n(?: {24}\S+\n)+)", listing, re.MULTILINE):
        (tmp_path / name).write_text("".join(f"{row.strip()}\n" for row in rows.splitlines()), encoding="utf-8")
    block = read_block(tmp_path)
    a = adjust_block(block)
    assert (a.observations, a.unknowns, a.redundancy) == (16, 15, 1)
    assert a.status.ok
    assert a.points.values[3].tolist() == pytest.approx([-500.0, 0.0, 0.0], abs=1e-6)
    write_block(block, tmp_path / "copy")
    for name in COLUMNS:
        assert (tmp_path / "copy" / f"{name}.csv").read_text() == (tmp_path / f"{name}.csv").read_text()


def test_continuous_integration_can_be_started() -> None:
    assert os.access(TOP / ".ci/run", os.X_OK)
