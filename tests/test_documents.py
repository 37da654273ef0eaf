"""What the documents say is executed: every code block, and the smallest block folder of the conventions."""

from __future__ import annotations

import csv
import os
import re
from pathlib import Path

import pytest

from adjust import adjust_block
from simfield.files.block_folder import read_block, write_block
from simfield.files.columns import BLOCK as COLUMNS
from tests.document_session import Piece, Session, pieces

TOP = Path(__file__).parents[1]
CONVENTIONS = (TOP / "docs/conventions.md").read_text(encoding="utf-8")
PAGES = [TOP / "README.md", *sorted(p for p in (TOP / "docs").rglob("*.md") if "_build" not in p.parts)]
BLOCKS = {page.relative_to(TOP).as_posix(): pieces(page) for page in PAGES}
LONG = {
    "README.md",
    "docs/tutorial.md",
    "docs/studies.md",
    "docs/howto/cluster.md",
    "docs/howto/own-block.md",
    "docs/howto/sql-and-r.md",
}
"""pages that take more than a few seconds"""

NOT_RUN = {
    r"python3 -m venv \.venv$": "python3 -m venv .venv",
    r"\. \.venv/bin/activate$": ". .venv/bin/activate",
    r"pip install ": "pip install ...",
    r"make [a-z-]+( |$)": "make ...",
    r"\.ci/run( |$)": ".ci/run",
}
"""lines of shell blocks that are not run here, and how docs/development.md lists them"""
SHORTENED = {
    "simfield reproduce ziemann-1982": "simfield reproduce ziemann-1982 --trials 2 --jobs 2",
    "simfield budget": "simfield budget --trials 2",
    "simfield detection": "simfield detection --trials 2 --contests 2 --blocks 2",
    "simfield run ap-models --jobs 4": "simfield run ap-models --jobs 2 --trials 64",
    "simfield run ap-models --trials 4000": "simfield run ap-models --jobs 2 --trials 128",
    "simfield run ap-models --trials 500": "simfield run ap-models --trials 64",
}
"""lines that would take minutes, and what is run instead; docs/development.md lists them"""
LAST_DIGIT = 0.00051
"""half a unit of the third decimal, and a little for rounding half up"""
SHELL_OR_PYTHON = re.compile(r" {4,}(simfield [a-z]+|make [a-z]|pip |python3? |from \w+ import |import \w)")


@pytest.mark.parametrize(
    "page",
    [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name, blocks in BLOCKS.items() if blocks],
)
def test_every_block_of_a_page_does_what_it_says(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    Session(tmp_path, BLOCKS[page], [re.compile(line) for line in NOT_RUN], SHORTENED).run()


def test_every_page_with_a_long_session_is_there() -> None:
    assert set(BLOCKS) >= LONG


def test_no_code_hides_in_a_listing_that_is_not_run() -> None:
    hidden = [
        f"{name}: {line.strip()}"
        for name in BLOCKS
        for line in re.sub(r"^```.*?^```$", "", (TOP / name).read_text(), flags=re.DOTALL | re.MULTILINE).splitlines()
        if SHELL_OR_PYTHON.match(line)
    ]
    assert hidden == []


def test_what_is_not_run_is_listed() -> None:
    listed = (TOP / "docs/development.md").read_text(encoding="utf-8")
    for line in NOT_RUN.values():
        assert f"`{line}`" in listed
    for line in SHORTENED:
        assert f"`{' '.join(line.split()[:3])}`" in listed


def test_every_line_that_is_not_run_names_something_that_exists() -> None:
    makefile = (TOP / "Makefile").read_text()
    lines = [line for blocks in BLOCKS.values() for b in blocks if b.language == "sh" for line in b.text.splitlines()]
    targets = {found[1] for line in lines if (found := re.match(r"make ([a-z-]+)", line))}
    assert targets >= {"install", "test", "check", "docs", "reproduce", "bench"}
    assert [target for target in targets if f"\n{target}:" not in makefile] == []


@pytest.mark.parametrize(
    ("language", "text", "complaint"),
    [
        ("python", "assert 1 == 2, 'no'\n", "no"),
        ("sh", "simfield models nothing\n", "exit code 2"),
        ("output", "something\n", "but it printed"),
        ("toml", "[methods]\napp = ['none']\n", "app"),
        ("sql", "SELECT 1 WHERE false", "no rows"),
        ("bash", "simfield run a.toml --jbos 2\n", "simfield run"),
        ("bash", "if true\n", "syntax error"),
        ("r", 'read_parquet("there/is/none.parquet")\n', "none.parquet"),
    ],
)
def test_a_block_that_does_not_do_what_it_says_is_found(
    language: str, text: str, complaint: str, tmp_path: Path
) -> None:
    with pytest.raises((AssertionError, ValueError), match=complaint):
        Session(tmp_path, [Piece("page", 1, language, text)], [], {}).run()


def test_the_figures_of_the_erratum_are_those_of_the_results() -> None:
    page = (TOP / "docs/explanation/erratum-1980.md").read_text(encoding="utf-8")
    with (TOP / "results/mauelshagen-1980/table2_rms.csv").open() as file:
        rms = {(r["variant"], r["aux_points"]): r["as_labelled"] for r in csv.DictReader(file) if r["camera"] == "ww"}
    rows = re.findall(r"^\| [^|]+ \| (0\.\d{3}) \| (0\.\d{3}) \|$", page, re.MULTILINE)
    order = ("as_printed", "b4_only", "sign_only", "corrected")
    computed = [[float(rms[v, "false"]), float(rms[v, "true"])] for v in order]
    assert [[float(figure) for figure in row] for row in rows] == [
        pytest.approx(row, abs=LAST_DIGIT) for row in computed
    ]


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
