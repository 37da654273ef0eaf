"""What the tables of a block have in common: read-only arrays, and the first defect named with its place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

SIGMA_LEAST, SIGMA_MOST = 1e-50, 1e50
"""of standard deviations in any unit: the squares beyond lie near the ends of what a float can hold"""


class BlockError(ValueError):
    """A defect of a block, with its place: the table, the row (0-based, None for the whole table) and the column."""

    def __init__(self, table: str, reason: str, row: int | None = None, column: str | None = None) -> None:
        self.table, self.row, self.column, self.reason = table, row, column, reason
        place = table + (f" row {row}" if row is not None else "") + (f", {column}" if column else "")
        super().__init__(f"{place}: {reason}")


def freeze(table: Any, **dtypes: Any) -> None:
    """Own a read-only, contiguous copy of every named array."""
    for name, dtype in dtypes.items():
        array = np.array(getattr(table, name), dtype=dtype, order="C")
        array.flags.writeable = False
        object.__setattr__(table, name, array)


def check_shape(table: str, name: str, array: npt.NDArray[Any], shape: tuple[int, ...]) -> None:
    if array.shape != shape:
        raise BlockError(table, f"{name} has shape {array.shape}, needed is {shape}")


def check_ids(table: str, ids: Sequence[object], column: str) -> None:
    if not ids:
        raise BlockError(table, "is empty")
    seen: dict[str, int] = {}
    for row, name in enumerate(ids):
        if not isinstance(name, str) or not name or name != name.strip():
            raise BlockError(table, f"{name!r} is not an id (a text without blanks at its ends)", row, column)
        if name in seen:
            raise BlockError(table, f"{name!r} stands already in row {seen[name]}", row, column)
        seen[name] = row


def refuse(table: str, bad: npt.NDArray[np.bool_], columns: Sequence[str], values: Floats, rule: str) -> None:
    """Raise for the first True of bad (rows, columns)."""
    if bad.any():
        row, column = (int(i) for i in np.argwhere(bad)[0])
        raise BlockError(table, f"{values[row, column]:.6g} is not allowed, {rule}", row, columns[column])


def refuse_weightless(table: str, sigma: Floats, columns: Sequence[str]) -> None:
    """Raise for a standard deviation (rows, columns) so large or small that its weight would not be a number; 0 and
    NaN have meanings of their own and are let through."""
    extreme = (sigma > SIGMA_MOST) | ((sigma > 0.0) & (sigma < SIGMA_LEAST))
    refuse(table, extreme, columns, sigma, f"a standard deviation is between {SIGMA_LEAST:g} and {SIGMA_MOST:g}")


def check_index(table: str, index: Indices, size: int, column: str) -> None:
    bad = (index < 0) | (index >= size)
    if bad.any():
        row = int(np.argmax(bad))
        raise BlockError(table, f"index {int(index[row])} is outside 0..{size - 1}", row, column)
