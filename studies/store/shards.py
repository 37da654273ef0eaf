"""A shard: some columns of equal length as a Parquet file that says what it is and notices every flipped bit.

The metadata of the file hold what the shard is (`label`) and the SHA-256 of the whole file, with zeros in the place
of its own digits; every page has its checksum besides. Nothing is believed before it is checked: the SHA-256 before
anything is parsed (a flipped bit in the footer can abort the process in the Parquet library), then the sizes in the
header, before a page is unpacked.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

FORMAT = "simfield-shard-1"
KEY = b"simfield"
MARK = b"sha256 of this file with zeros here: "
ZEROS = b"0" * 64
MOST_BYTES = 1 << 30
MOST_COLUMNS = 100_000
DTYPES = {np.dtype(name): name for name in ("int8", "float64")}

Columns = dict[str, npt.NDArray[Any]]
BEFORE = "|"
"""stands between method and quantity in a column's name"""


class DamageError(ValueError):
    """The file is not the whole shard that it should be; one line says why."""


class ForeignError(DamageError):
    """The file is a whole shard, of another study."""


def encode(columns: Mapping[str, npt.NDArray[Any]], label: Mapping[str, Any]) -> bytearray:
    """The bytes of a shard: columns of int8 or float64, all of one length, and a label of plain values."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    header = json.dumps({**label, "format": FORMAT, "sha256": (MARK + ZEROS).decode()}, sort_keys=True)
    kinds = {dtype: pa.type_for_alias(name) for dtype, name in DTYPES.items()}
    arrays = [_array(pa, kinds, values) for values in columns.values()]
    table = pa.Table.from_arrays(arrays, names=list(columns))
    sink = pa.BufferOutputStream()
    plain: dict[str, Any] = {"compression": "none", "use_dictionary": False, "write_statistics": False}
    with pq.ParquetWriter(sink, table.schema, **plain, write_page_checksum=True, store_schema=False) as writer:
        writer.write_table(table, row_group_size=max(1, table.num_rows))
        writer.add_key_value_metadata({KEY: header})
    raw = bytearray(sink.getvalue())
    _seal(raw)
    return raw


def _array(pa: Any, kinds: Mapping[Any, Any], values: npt.NDArray[Any]) -> Any:
    """An Arrow array over the values themselves; pa.array would import pandas to look whether they are its own."""
    return pa.Array.from_buffers(kinds[values.dtype], len(values), [None, pa.py_buffer(np.ascontiguousarray(values))])


def _seal(raw: bytearray) -> None:
    """Put the SHA-256 of the file in the place of the zeros."""
    place = raw.rindex(MARK) + len(MARK)
    raw[place : place + len(ZEROS)] = hashlib.sha256(raw).hexdigest().encode()


def _refuse_changed(raw: bytes) -> None:
    """Raise DamageError unless every byte is as it was written."""
    place = raw.rfind(MARK) + len(MARK)
    claimed = raw[place : place + len(ZEROS)]
    if place < len(MARK) or len(claimed) < len(ZEROS):
        raise DamageError("the file is cut off, or no shard of simfield")
    view = memoryview(raw)
    sha = hashlib.sha256(view[:place])
    sha.update(ZEROS)
    sha.update(view[place + len(ZEROS) :])
    if sha.hexdigest().encode() != claimed:
        raise DamageError("the file does not have the SHA-256 that it claims")


def decode(raw: bytes, expected: Mapping[str, Any], most_rows: int) -> Columns:
    """The columns of a shard whose label has the expected entries. Raises DamageError for anything else."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    if not raw:
        raise DamageError("the file is empty")
    _refuse_changed(raw)
    try:
        limits = {"thrift_string_size_limit": 1 << 24, "thrift_container_size_limit": 1 << 20}
        file = pq.ParquetFile(pa.BufferReader(raw), page_checksum_verification=True, pre_buffer=False, **limits)
        header = _header(file.metadata, most_rows)
        table = file.read(use_threads=False)
        columns = {name: _values(table.column(name)) for name in table.column_names}
    except DamageError:
        raise
    except (pa.ArrowException, OSError, ValueError, KeyError, TypeError, MemoryError, OverflowError) as error:
        raise DamageError(f"no whole Parquet file: {_first_line(error)}") from None
    for name, value in expected.items():
        if header.get(name) != value:
            kind = ForeignError if name == "study" else DamageError
            raise kind(f"{name} is {header.get(name)!r}, not {value!r}")
    return columns


def _header(metadata: Any, most_rows: int) -> dict[str, Any]:
    """What the shard says it is, after the sizes in the file's own header have been found plausible."""
    rows, columns = metadata.num_rows, metadata.num_columns
    if not 0 <= rows <= most_rows or columns > MOST_COLUMNS or metadata.num_row_groups > 1:
        raise DamageError(f"the header claims {rows} rows, {columns} columns; at most {most_rows} rows are possible")
    for group in range(metadata.num_row_groups):
        for column in range(columns):
            size = metadata.row_group(group).column(column).total_uncompressed_size
            if not 0 <= size <= 8 * rows + 4096:
                raise DamageError(f"the header claims {size} bytes for column {column} with {rows} rows")
    header = json.loads((metadata.metadata or {}).get(KEY, b"{}"))
    if not isinstance(header, dict) or header.get("format") != FORMAT:
        raise DamageError("this is no shard of simfield")
    return header


def _values(column: Any) -> npt.NDArray[Any]:
    values = np.asarray(column.to_numpy())
    if values.dtype not in DTYPES or column.null_count:
        raise DamageError(f"a column holds {values.dtype.name}, allowed are {' and '.join(DTYPES.values())}")
    return values


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0][:200]
