"""The summary of a study read back from its CSV files, which must agree with the study in every line.

The text is read, not the Parquet file beside it: one flipped bit in that file's footer can end the process.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from studies.design import Method, Plan, references
from studies.store import StoreError
from studies.summary.cells import unit
from studies.summary.over_geometries import LAST
from studies.summary.summary import Row, Summary, to_csv

NUMBERS = ("n", "failures", "estimate", "mcse")
OF_GEOMETRIES = ("geometries", "geometry_se")
COUNTS, ERRORS = ("n", "failures", "geometries"), ("mcse", "geometry_se")
MOST_BYTES = 256 << 20
RELATIVE, MCSE_RELATIVE, ROUNDING = 1e-6, 1e-3, 1e-9
"""differences from what the trials say: ten digits are written, four of a standard error; a correlation of 0 is not"""


class NothingToReportError(RuntimeError):
    """The folder holds no results yet, or none of ours."""


def read_summary(plan: Plan, folder: Path) -> Summary:
    """Rows and differences as they were written; failures are left to the trials.

    Raises NothingToReportError without a summary, StoreError with file and line where one does not fit the study.
    """
    if not (folder / "summary.csv").is_file():
        raise NothingToReportError(f"{folder}: there is no summary yet; `simfield run` goes on where the study stopped")
    rows = list(_rows(plan, folder / "summary.csv", ()))
    _refuse_gaps(plan, rows, folder / "summary.csv")
    path = folder / "differences.csv"
    return Summary(rows, list(_rows(plan, path, ("against",))) if path.is_file() else [], ())


def _rows(plan: Plan, path: Path, more: tuple[str, ...]) -> Iterator[Row]:
    lines = _lines(path)
    header = next(lines, [])
    heads = [_head(plan, c.id, c.columns, m) for c in plan.firsts for m in plan.methods]
    by_text = {tuple(_texts(head)[1]): head for head in heads}
    compared = references(plan.study)
    numbers = NUMBERS + (OF_GEOMETRIES if plan.study.trials.geometries > 1 else ())
    names = [*(heads[0] if heads else ()), *more, "measure", "unit", *numbers]
    if header and header != _texts(dict.fromkeys(names, ""))[0]:
        raise StoreError(f"{path}: damaged or of another study: its header is not {', '.join(names)}")
    place = names.index("method")
    for number, line in enumerate(lines, start=2):
        where = f"{path}, line {number}"
        if len(line) != len(names):
            raise StoreError(f"{where}: damaged: {len(line)} cells instead of {len(names)}")
        head = by_text.get(tuple(line[: place + 1]))
        if head is None:
            raise StoreError(f"{where}: damaged or of another study: no such condition and method")
        tail = dict(zip(names[place + 1 :], line[place + 1 :], strict=True))
        if "against" in tail and _unquoted(tail["against"]) != compared.get(head["method"]):
            raise StoreError(f"{where}: damaged or of another study: {head['method']} is not compared with that method")
        yield {**head, **_numbers(tail, numbers, where)}


def _head(plan: Plan, condition: str, levels: Mapping[str, Any], method: Method) -> Row:
    shown = {key: value for key, value in method.columns.items() if key in plan.study.methods}
    return {"condition": condition, **levels, **shown, "method": method.key}


def _texts(row: Row) -> list[list[str]]:
    """Header and cells of a row as they are written."""
    return list(csv.reader(io.StringIO(to_csv([row]).decode(), newline="")))


def _unquoted(text: str) -> str:
    return text.removeprefix("'")


def _lines(path: Path) -> Iterator[list[str]]:
    if path.is_symlink() or path.stat().st_size > MOST_BYTES:
        raise StoreError(f"{path}: is a link or too large to be ours")
    try:
        yield from csv.reader(io.StringIO(path.read_bytes().decode("utf-8"), newline=""), strict=True)
    except (UnicodeDecodeError, csv.Error) as error:
        raise StoreError(f"{path}: damaged: {error}") from None


def _numbers(tail: Mapping[str, str], names: Sequence[str], where: str) -> Row:
    measure = _unquoted(tail["measure"])
    if tail["unit"] != unit(measure):
        raise StoreError(f"{where}: damaged: {tail['unit']!r} is not the unit of {measure!r}")
    try:
        counts = {name: int(tail[name]) for name in names if name in COUNTS}
        values = {name: float(tail[name]) if tail[name] else math.nan for name in names if name not in COUNTS}
    except ValueError as error:
        raise StoreError(f"{where}: damaged: {error}") from None
    if min(counts.values()) < 0 or any(math.isinf(v) for v in values.values()) or _negative(values):
        raise StoreError(f"{where}: damaged: impossible numbers")
    against = {"against": _unquoted(tail["against"])} if "against" in tail else {}
    found = {**counts, **values}
    return {**against, "measure": measure, "unit": tail["unit"], **{name: found[name] for name in names}}


def _negative(values: Mapping[str, float]) -> bool:
    return any(values.get(name, 0.0) < 0.0 for name in ERRORS)


def _refuse_gaps(plan: Plan, rows: list[Row], path: Path) -> None:
    """Every cell must be there, once, from its first to its last measure."""
    seen = [(row["condition"], row["method"], row["measure"]) for row in rows]
    if len(set(seen)) < len(seen):
        raise StoreError(f"{path}: damaged: a measure stands there twice")
    whole = {(condition, method) for condition, method, measure in seen if measure == LAST}
    missing = [(c, m) for c in plan.firsts for m in plan.methods if (c.id, m.key) not in whole]
    if missing:
        condition, method = missing[0]
        raise StoreError(f"{path}: {len(missing)} cells are missing or cut off, such as {condition}, {method.key}")


def refuse_other_numbers(written: Summary, computed: Summary, path: Path) -> None:
    """Raise StoreError where the summary does not say what the trials say."""
    fresh = {(row["condition"], row["method"], row["measure"]): row for row in computed.rows}
    for row in written.rows:
        other = fresh.get((row["condition"], row["method"], row["measure"]))
        if other is None or not all(_close(row, other, name) for name in (*NUMBERS, *OF_GEOMETRIES) if name in row):
            raise StoreError(
                f"{path}: not what the trials say: {row['measure']} of {row['method']}, condition {row['condition']}; "
                "`simfield run` writes it anew"
            )


def _close(row: Row, other: Row, name: str) -> bool:
    a, b = float(row[name]), float(other[name])
    error = float(other["mcse"]) if math.isfinite(other["mcse"]) else 0.0
    tolerance = MCSE_RELATIVE * abs(b) if name in ERRORS else RELATIVE * (abs(b) + error)
    return abs(a - b) <= tolerance + (ROUNDING if other["unit"] == "1" else 0.0) or (a != a and b != b)
