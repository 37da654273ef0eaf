"""The summary of a study: one row a condition, method and measure, and the differences between methods, in pairs."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from studies.design import Condition, Plan, references
from studies.store import SENTENCES, Store, joined
from studies.summary import performance, stopping
from studies.summary.cells import Cell, correlated, measured, unit
from studies.summary.over_geometries import over_geometries, with_correlated
from studies.summary.performance import Measured
from studies.texts import as_text

Row = dict[str, Any]
MOST_NAMED = 6
"""columns in a line"""
DIGITS = {"estimate": ".10g", "mcse": ".4g", "geometry_se": ".4g"}


@dataclass(frozen=True)
class Summary:
    """rows and differences in the order of plan, method, measure; failures: a line for each cell without a result;
    notes: what a reader has to know besides.
    """

    rows: list[Row]
    differences: list[Row]
    failures: tuple[str, ...]
    notes: tuple[str, ...] = ()


def summarise(plan: Plan, store: Store) -> Summary:
    """Everything from the shards. Raises DamageError or FileNotFoundError where one is not whole."""
    rows: list[Row] = []
    differences: list[Row] = []
    failures: list[str] = []
    left_out: Counter[str] = Counter()
    least = plan.study.report.least_correlation
    for situation in plan.situations:
        # which pairs are correlated enough is decided by all geometries together
        each = [_of_condition(plan, store, c, least if len(situation) == 1 else 0.0, left_out) for c in situation]
        failures += [line for found in each for line in found.failures]
        if plan.study.trials.geometries == 1:
            rows += each[0].rows
            differences += each[0].differences
            continue
        head = _head(situation[0])
        rows += with_correlated(over_geometries([found.rows for found in each], head), least)
        differences += over_geometries([found.differences for found in each], head)
    return Summary(rows, differences, tuple(failures), _notes(left_out, len(plan.conditions) * len(plan.methods)))


def _of_condition(plan: Plan, store: Store, condition: Condition, least: float, left_out: Counter[str]) -> Summary:
    """Rows, differences and failures of one condition; counts the columns that are left out."""
    rows: list[Row] = []
    failures: list[str] = []
    columns, nominal = joined(store, plan, condition, stopping.trials_of(plan, store, condition))
    cells = {m.key: Cell.of(m.key, columns, nominal) for m in plan.methods}
    found = {key: measured(cell) for key, cell in cells.items()}
    for method in plan.methods:
        cell = cells[method.key]
        head = {**_head(condition), **_shown_keys(plan, method.columns), "method": method.key}
        rows += [{**head, **row} for row in _rows(cell, found[method.key], least)]
        left_out.update(cell.left_out)
        if cell.lost:
            failures.append(f"{condition}, {method.key}: {_what_failed(cell)}")
    return Summary(rows, list(_differences(plan, condition, cells, found)), tuple(failures))


def _notes(left_out: Counter[str], cells: int) -> tuple[str, ...]:
    """What is left out because not all blocks of a cell were written with the columns of this version, in a line."""
    if not left_out:
        return ()
    named = [f"{name} (in {count} of {cells} cells)" for name, count in left_out.most_common(MOST_NAMED)]
    more = f" and {len(left_out) - MOST_NAMED} more columns" if len(left_out) > MOST_NAMED else ""
    return (
        f"left out: {', '.join(named)}{more}; a version of simfield with other columns wrote blocks in trials/, which "
        "are kept; without that folder everything is computed anew",
    )


def _head(condition: Condition) -> Row:
    return {"condition": condition.id, **condition.columns}


def _shown_keys(plan: Plan, columns: Mapping[str, Any]) -> Row:
    """The columns of a method that the study file speaks of."""
    return {key: value for key, value in columns.items() if key in plan.study.methods}


def _what_failed(cell: Cell) -> str:
    codes, counts = np.unique(cell.status[~cell.kept], return_counts=True)
    named = [f"{count} x {SENTENCES.get(int(code), 'failed')}" for code, count in zip(codes, counts, strict=True)]
    return f"{cell.failures} of {len(cell.status)} trials failed: {'; '.join(named)}"


def _rows(cell: Cell, measures: Mapping[str, Measured], least_correlation: float) -> Iterator[Row]:
    n, failures = len(cell.status) - cell.failures, cell.failures
    for name, found in measures.items():
        yield _row(name, n, failures, found.estimate[0], found.mcse[0])
    for pair, (formal, found) in correlated(cell, least_correlation).items():
        yield _row(f"formal_correlation {pair}", n, failures, formal, 0.0)
        yield _row(f"correlation {pair}", n, failures, found.estimate[0], found.mcse[0])
    failed = (~cell.kept).astype(float)[:, None]
    share = performance.coverage(failed)
    yield _row("failure_share", n, failures, share.estimate[0], share.mcse[0])


def _row(measure: str, n: int, failures: int, estimate: float, mcse: float) -> Row:
    numbers = {"n": n, "failures": failures, "estimate": float(estimate), "mcse": float(mcse)}
    return {"measure": measure, "unit": unit(measure), **numbers}


def _differences(
    plan: Plan, condition: Condition, cells: Mapping[str, Cell], measures: Mapping[str, dict[str, Measured]]
) -> Iterator[Row]:
    known = {m.key: m for m in plan.methods}
    for key, reference in references(plan.study).items():
        if reference not in cells or not len(cells[key].error) or not len(cells[reference].error):
            continue
        both = cells[key].kept & cells[reference].kept
        first, second = (_measured_on(cells[k], both, measures[k]) for k in (key, reference))
        head = {**_head(condition), **_shown_keys(plan, known[key].columns), "method": key, "against": reference}
        for name in first:
            if name in second:
                found = performance.difference(first[name], second[name])
                row = _row(name, int(both.sum()), int(np.sum(~both)), found.estimate[0], found.mcse[0])
                yield {**head, **row}


def _measured_on(cell: Cell, both: npt.NDArray[np.bool_], measures: dict[str, Measured]) -> dict[str, Measured]:
    """The measures of the trials in which both methods converged; `measures` are those of all trials of the cell."""
    inner = both[cell.kept]
    if inner.all():
        return measures
    deviations = {name: values[inner] for name, values in cell.deviations.items()}
    return measured(replace(cell, deviations=deviations, error=cell.error[inner], std=cell.std[inner]))


def write(summed: Summary, plan: Plan, folder: Path) -> list[Path]:
    """Write summary.csv, summary.parquet and, where methods are compared, differences.csv. Raises OSError."""
    tables = {"summary.csv": to_csv(summed.rows), "summary.parquet": to_parquet(summed.rows)}
    if references(plan.study):
        tables["differences.csv"] = to_csv(summed.differences)
    for name, content in tables.items():
        (folder / name).write_bytes(content)
    return [folder / name for name in tables]


def to_csv(rows: list[Row]) -> bytes:
    """Rows as CSV: a missing number is an empty cell, and no text is taken for a formula by a spreadsheet."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    if rows:
        writer.writerow([_cell("", name) for name in rows[0]])
    writer.writerows([_cell(name, value) for name, value in row.items()] for row in rows)
    return text.getvalue().encode()


def _cell(name: str, value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return "" if value != value else format(value, DIGITS.get(name, "g"))
    return as_text(value) if isinstance(value, str) else str(value)


def to_parquet(rows: list[Row]) -> bytes:
    """Rows as Parquet, with page checksums; factor columns of mixed type become text."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = list(rows[0]) if rows else []
    arrays = [pa.array(_of_one_type(row[name] for row in rows)) for name in names]
    sink = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_arrays(arrays, names=names), sink, write_page_checksum=True)
    return bytes(sink.getvalue())


def _of_one_type(values: Iterable[Any]) -> list[Any]:
    found = list(values)
    kinds = {type(v) for v in found}
    if kinds <= {int, float}:
        return [float(v) for v in found] if float in kinds else found
    return found if len(kinds) <= 1 else [str(v) for v in found]
