"""A page of the documentation as a session: its code blocks run from top to bottom in one directory.

A block whose first line is `# name.ext` is written to that file. A block `output` is what the block before it prints;
`...` stands for anything, on a line of its own for any number of lines.
"""

from __future__ import annotations

import contextlib
import glob
import io
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

FENCE = re.compile(r"^```([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
FILE_NAME = re.compile(r"# (\S+\.(?:py|toml))\n")
SECONDS = 300.0
"""a bound for hangs alone"""
SMALLEST_STUDY: Mapping[str, Any] = {
    "study": {"name": "fragment", "question": "Does the fragment fit into a study?", "seed": 1},
    "trials": {"max": 512},
    "scenario": {"preset": "grid-small"},
    "methods": {"ap": ["none"]},
    "report": {"x": "ap", "measures": ["m0_um"]},
}


@dataclass(frozen=True)
class Piece:
    """A fenced block: where it stands, its language and its text."""

    page: str
    line: int
    language: str
    text: str

    @property
    def place(self) -> str:
        return f"{self.page}, line {self.line}"

    @property
    def file_name(self) -> str | None:
        found = FILE_NAME.match(self.text)
        return found[1] if found else None


def pieces(path: Path) -> list[Piece]:
    """The fenced blocks of a page, without the directives of Sphinx."""
    text = path.read_text(encoding="utf-8")
    return [
        Piece(path.name, 2 + text.count("\n", 0, found.start()), found[1].strip(), found[2])
        for found in FENCE.finditer(text)
        if not found[1].startswith("{")
    ]


@dataclass
class Session:
    """One page in one folder; skipped and longer name lines of the shell that are not run, or run with more options."""

    folder: Path
    page: Sequence[Piece]
    skipped: Sequence[re.Pattern[str]]
    shortened: Mapping[str, str]
    names: dict[str, Any] = field(default_factory=lambda: {"__name__": "__main__"})
    printed: str = ""

    def run(self) -> None:
        """Run every block. Raises AssertionError with the place of the first that does not do what it says."""
        for piece in self.page:
            if piece.file_name:
                (self.folder / piece.file_name).write_text(piece.text, encoding="utf-8")
            getattr(self, f"_{piece.language}")(piece)

    def _python(self, piece: Piece) -> None:
        if piece.file_name and any(f"python {piece.file_name}" in other.text for other in self.page):
            return
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(piece.text, piece.place, "exec"), self.names)
        self.printed = printed.getvalue()

    def _sh(self, piece: Piece) -> None:
        lines = [line for line in piece.text.splitlines() if not any(p.match(line) for p in self.skipped)]
        script = "\n".join(self._shortened(line) for line in lines)
        path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
        done = subprocess.run(
            ["bash", "-eu", "-c", script],
            cwd=self.folder,
            env={**os.environ, "PATH": path, "PYTHONWARNINGS": "error"},
            capture_output=True,
            text=True,
            timeout=SECONDS,
        )
        assert done.returncode == 0, f"{piece.place}: exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        self.printed = done.stdout

    def _shortened(self, line: str) -> str:
        for start, instead in self.shortened.items():
            if line.startswith(start):
                return line.replace(start, instead, 1)
        return line

    def _output(self, piece: Piece) -> None:
        pattern = "\n".join(_line_pattern(line) for line in piece.text.splitlines())
        assert re.fullmatch(pattern, self.printed.rstrip("\n")), (
            f"{piece.place}: expected\n{piece.text}\nbut it printed\n{self.printed}"
        )

    def _toml(self, piece: Piece) -> None:
        from simfield.scenario.scenario_file import scenario_from_table
        from studies.design.study_file import study_from_text

        table = tomllib.loads(piece.text)
        if "cameras" in table and "flights" in table:
            scenario_from_table(table)
            return
        missing = {name: content for name, content in SMALLEST_STUDY.items() if name not in table}
        study_from_text(_as_toml(missing) + piece.text)

    def _sql(self, piece: Piece) -> None:
        import duckdb

        for statement in filter(str.strip, piece.text.split(";")):
            assert duckdb.sql(statement).fetchall(), f"{piece.place}: no rows"

    def _bash(self, piece: Piece) -> None:
        """A script for a machine that is not here: the shell can parse it, and its simfield commands are possible."""
        done = subprocess.run(["bash", "-n"], input=piece.text, capture_output=True, text=True)
        assert done.returncode == 0, f"{piece.place}: {done.stderr}"
        for command, rest in re.findall(r"\bsimfield ([a-z]+)([^\n&|]*)", piece.text):
            assert set(re.findall(r"(?<=\s)--[a-z-]+", rest)) <= options(command), f"{piece.place}: simfield {command}"

    def _r(self, piece: Piece) -> None:
        """R is not here: the files that the block names are there, and so are the columns."""
        import pyarrow.parquet as pq

        quoted = re.findall(r'"([^"]+)"', piece.text)
        files = {name: sorted(glob.glob(name, root_dir=self.folder)) for name in quoted if "/" in name}
        assert files
        assert all(files.values()), f"{piece.place}: {files}"
        columns = {c for found in files.values() for c in pq.read_schema(self.folder / found[0]).names}
        wanted = {name for name in quoted if "|" in name}
        wanted |= {name.strip() for names in re.findall(r"select\(([^)]*)\)", piece.text) for name in names.split(",")}
        assert wanted <= columns, f"{piece.place}: {wanted - columns}"

    def _text(self, piece: Piece) -> None:
        """A drawing, no code."""


def options(command: str) -> set[str]:
    """The options of a simfield command."""
    from studies.commands.program import main

    return {name for parameter in main.commands[command].params for name in parameter.opts}


def _line_pattern(line: str) -> str:
    if line.strip() == "...":
        return r"[\s\S]*"
    return ".*".join(re.escape(part) for part in line.rstrip().split("..."))


def _as_toml(tables: Mapping[str, Mapping[str, Any]]) -> str:
    """Tables of numbers, texts and lists of texts, whose JSON is TOML too."""
    import json

    return "".join(
        f"[{name}]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in table.items()) + "\n"
        for name, table in tables.items()
    )
