"""A strict CSV table: UTF-8, comma, a header of known names; every refusal names file, row and column.

Rows are counted as a text editor counts lines: the header is row 1. A byte-order mark and empty lines are passed over.
Time and memory are bounded by the size of the file: a line over LONGEST_LINE is refused before it is split.
"""

from __future__ import annotations

import csv
import io
import math
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np

from simfield.block import Floats, Indices, resembling
from simfield.files.degrees import radians_of

LONGEST_LINE = 1_000_000
LONGEST_REASON = 400
CHUNK = 10_000
"""rows turned into columns at a time: half a million row lists alive at once cost the garbage collector seconds"""
SEPARATORS = {";": "semicolons", "\t": "tabs", "|": "bars"}
NOT_OF_A_NUMBER = re.compile(r"[^0-9eE+\-. ]")
DECIMAL_COMMA = re.compile(r" *[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]+)? *")


class BlockFolderError(ValueError):
    """A file that cannot be read as, or written into, a block folder: one line with its place.

    file is the path, row the line in the file (the header is 1; None for the whole file), column a name of the header.
    """

    def __init__(self, file: Path, reason: str, row: int | None = None, column: str | None = None) -> None:
        if len(reason) > LONGEST_REASON:
            reason = f"{reason[: LONGEST_REASON // 2]} ... {reason[-LONGEST_REASON // 2 :]}"
        self.file, self.row, self.column, self.reason = file, row, column, reason
        place = f"{file}" + (f", row {row}" if row is not None else "") + (f", column {column}" if column else "")
        super().__init__(" ".join(f"{place}: {reason}".splitlines()))


@dataclass(frozen=True)
class CsvTable:
    """The columns of a file as texts, with the line on which each row begins."""

    path: Path
    lines: Sequence[int]
    columns: dict[str, tuple[str, ...]]

    def error(self, reason: str, row: int | None = None, column: str | None = None) -> BlockFolderError:
        """The error at the 0-based data row and the column."""
        return BlockFolderError(self.path, reason, None if row is None else self.lines[row], column)

    def numbers(self, column: str, *, may_be_empty: bool = False) -> Floats:
        """The finite numbers of a column, NaN where it is empty.

        Raises BlockFolderError for a text that is no finite number, and for an empty one unless that is allowed.
        """
        texts = self.columns[column]
        if not may_be_empty and "" in texts:
            raise self.error("is empty, a number is needed", texts.index(""), column)
        try:
            values = np.array([float(text) if text else math.nan for text in texts])
            sound = not NOT_OF_A_NUMBER.search("".join(texts)) and not bool(np.isinf(values).any())
        except ValueError:
            sound = False
        if not sound:
            row, defect = next((row, defect) for row, text in enumerate(texts) if (defect := _number_defect(text)))
            raise self.error(defect, row, column)
        return values

    def index(self, column: str) -> dict[str, int]:
        """The 0-based row of every id in a column.

        Raises BlockFolderError for an id that is empty, begins or ends with a blank, or stands there twice.
        """
        rows: dict[str, int] = {}
        for row, name in enumerate(self.columns[column]):
            if not name or name != name.strip():
                raise self.error(f"{shown(name)} is not an id (a text without blanks at its ends)", row, column)
            if (first := rows.setdefault(name, row)) != row:
                raise self.error(f"{shown(name)} stands already in row {self.lines[first]}", row, column)
        return rows

    def radians(self, column: str) -> Floats:
        """The angles of a column in degrees, rad, NaN where it is empty. Raises BlockFolderError as `numbers`."""
        self.numbers(column, may_be_empty=True)  # refuses what is not a number, with its place
        return np.array([radians_of(text.strip()) for text in self.columns[column]])

    def rows_of(self, column: str, other: CsvTable, named: str = "") -> Indices:
        """The rows of another table that a column of ids names; `named` is its column there, the same if empty.

        Raises BlockFolderError for an id that is not there.
        """
        rows = other.index(named or column)
        names = self.columns[column]
        found = np.array([rows.get(name, -1) for name in names], dtype=np.intp)
        if (found < 0).any():
            row = int(np.argmin(found))
            raise self.error(f"{shown(names[row])} is not in {other.path.name}", row, column)
        return found


def number_columns(*arrays: Floats) -> Iterator[list[float | str]]:
    """The columns of arrays (n, ...), NaN as an empty text; csv writes a float with the digits of its repr."""
    for column in np.concatenate(arrays, axis=1).T.tolist():
        yield ["" if value != value else value for value in column]


def read_table(path: Path, names: Sequence[str]) -> CsvTable:
    """The table in a file whose header has exactly these names, in any order.

    Raises BlockFolderError for a file that is missing, unreadable or not UTF-8, and for any defect of its form.
    """
    records = _records(path, _text(path, names))
    line, header = next(records, (0, None))
    if header is None:
        raise BlockFolderError(path, f"is empty, the first line must be {','.join(names)}")
    _check_header(path, line, header, names)
    lines: list[int] = []
    columns: list[list[str]] = [[] for _ in header]
    while chunk := list(islice(records, CHUNK)):
        for line, record in chunk:
            if len(record) != len(header):
                raise _miscounted(path, line, record, header)
            lines.append(line)
        for column, fields in zip(columns, zip(*(record for _, record in chunk), strict=True), strict=True):
            column.extend(fields)
    if not lines:
        raise BlockFolderError(path, "has a header but no rows")
    return CsvTable(path, lines, dict(zip(header, map(tuple, columns), strict=True)))


def shown(text: str) -> str:
    """A text from a file as it appears in a message: quoted, on one line, not too long."""
    return repr(text) if len(text) <= 60 else f"{text[:50]!r}... ({len(text)} characters)"


def _text(path: Path, names: Sequence[str]) -> str:
    try:
        if not path.exists():
            raise BlockFolderError(path, f"is missing, needed is a CSV file with the header {','.join(names)}")
        if not path.is_file():  # a folder, or a pipe that would never end
            raise BlockFolderError(path, "is not a regular file")
        data = path.read_bytes()
    except OSError as error:
        raise BlockFolderError(path, f"cannot be read: {os.strerror(error.errno or 0)}") from error
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise BlockFolderError(path, "is encoded in UTF-16, only UTF-8 is allowed", 1)
    if (at := data.find(b"\0")) >= 0:
        raise BlockFolderError(path, "has a NUL byte, this is not a text file in UTF-8", data.count(b"\n", 0, at) + 1)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row, byte = data.count(b"\n", 0, error.start) + 1, data[error.start]
        raise BlockFolderError(path, f"byte 0x{byte:02x} is not UTF-8, save the file as UTF-8", row) from None


def _records(path: Path, text: str) -> Iterator[tuple[int, list[str]]]:
    """Every record that is not an empty line, with the line where it begins."""
    _refuse_long_lines(path, text)
    reader = csv.reader(io.StringIO(text, newline=""), strict=True)
    while True:
        line = reader.line_num + 1
        try:
            record = next(reader)
        except StopIteration:
            return
        except csv.Error as error:
            raise BlockFolderError(path, f"is not CSV ({error}), is a quote not closed?", line) from None
        if record:
            yield line, record


def _refuse_long_lines(path: Path, text: str) -> None:
    if max(map(len, io.StringIO(text, newline="")), default=0) <= LONGEST_LINE:
        return
    for number, line in enumerate(io.StringIO(text, newline=""), start=1):
        if len(line) > LONGEST_LINE:
            raise BlockFolderError(path, f"has {len(line)} characters, at most {LONGEST_LINE} are allowed", number)


def _check_header(path: Path, line: int, header: Sequence[str], names: Sequence[str]) -> None:
    if separator := _other_separator(header):
        raise BlockFolderError(path, f"is separated by {separator}, only commas are allowed", line)
    seen: set[str] = set()
    for name in header:
        if name not in names:
            near = resembling(name, names)
            hint = f"did you mean {near}?" if near else f"known are {', '.join(names)}"
            raise BlockFolderError(
                path,
                f"unknown column {shown(name)}, {hint}",
                line,
                name if name.isprintable() and 0 < len(name) <= 60 else None,
            )
        if name in seen:
            raise BlockFolderError(path, "stands twice in the header", line, name)
        seen.add(name)
    for name in names:
        if name not in seen:
            raise BlockFolderError(path, f"is missing, the header must have {','.join(names)}", line, name)


def _miscounted(path: Path, line: int, record: Sequence[str], header: Sequence[str]) -> BlockFolderError:
    reason = f"has {len(record)} field(s), the header has {len(header)}"
    if separator := _other_separator(record):
        reason += f"; it is separated by {separator}, only commas are allowed"
    elif len(record) > len(header):
        reason += "; write decimal points, not decimal commas, and quote an id that contains a comma"
    return BlockFolderError(path, reason, line)


def _other_separator(record: Sequence[str]) -> str:
    """The name of the separator of a line that commas did not split, or of a line split at its decimal commas."""
    counts = {word: sum(field.count(mark) for field in record) for mark, word in SEPARATORS.items()}
    word, count = max(counts.items(), key=lambda item: item[1])
    return word if count >= len(record) else ""


def _number_defect(text: str) -> str:
    """Why a text is no number that may stand in a file; empty if it is one, or is empty itself."""
    if not text:
        return ""
    if DECIMAL_COMMA.fullmatch(text):
        return f"{shown(text)} has a decimal comma, write a decimal point"
    try:
        value = float(text)
    except ValueError:
        return f"{shown(text)} is not a number"
    if math.isnan(value):
        return f"{shown(text)} is not allowed, leave an unknown value empty where that is allowed"
    if math.isinf(value):
        return f"{shown(text)} is not allowed, must be finite"
    if NOT_OF_A_NUMBER.search(text):
        return f"{shown(text)} is not a number of the digits 0-9, point, sign and exponent"
    return ""
