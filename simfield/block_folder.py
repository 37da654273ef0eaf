"""A block as a folder of four CSV files, and back, without losing a bit.

Every float is written with the digits that read as the same float, angles in degrees (simfield.degrees), NaN as an
empty field. What each column means, its unit and what an empty field says: docs/conventions.md. Other files in the
folder are neither read nor touched.
"""

from __future__ import annotations

import csv
import io
import os
import re
import secrets
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from simfield.block import (
    COORDINATES,
    EXTERIOR,
    ROLES,
    SIGMAS,
    Block,
    BlockError,
    Camera,
    Floats,
    ImageObservations,
    Images,
    Indices,
    Points,
)
from simfield.csv_table import BlockFolderError, CsvTable, read_table, shown
from simfield.degrees import degrees_text, radians_of

__all__ = ["COLUMNS", "BlockFolderError", "read_block", "write_block"]

POSITIONS, ANGLES = EXTERIOR[:3], EXTERIOR[3:]
INTERIOR = ("c_mm", "x0_mm", "y0_mm", "width_mm", "height_mm")
COLUMNS: dict[str, tuple[str, ...]] = {
    "cameras": ("camera_id", *INTERIOR),
    "images": ("image_id", "camera_id", *EXTERIOR),
    "points": ("point_id", "role", *COORDINATES, *SIGMAS),
    "observations": ("image_id", "point_id", "x_mm", "y_mm", "sigma_x_mm", "sigma_y_mm"),
}
"""the header of every file, by the table's name in a BlockError; the file is the name with .csv"""
UNWRITABLE = re.compile("[\0\r\ud800-\udfff]")
LONGEST_ID = 100_000
"""characters; a CSV reader gives up at 131072"""


def read_block(path: str | os.PathLike[str]) -> Block:
    """The block in a folder.

    Raises BlockFolderError, one line with file, row, column, reason and what is allowed, at the first defect.
    """
    folder = Path(path)
    if folder.exists() and not folder.is_dir():
        raise BlockFolderError(folder, "is not a folder, needed is a folder with cameras.csv, images.csv, ...")
    if not folder.exists():
        raise BlockFolderError(folder, "does not exist, needed is a folder with cameras.csv, images.csv, ...")
    tables = {name: read_table(folder / f"{name}.csv", columns) for name, columns in COLUMNS.items()}
    try:
        return Block(
            _cameras(tables["cameras"]),
            _images(tables["images"], tables["cameras"]),
            _points(tables["points"]),
            _observations(tables["observations"], tables["images"], tables["points"]),
        )
    except BlockError as error:
        raise tables[error.table].error(error.reason, error.row, error.column) from error


def write_block(block: Block, path: str | os.PathLike[str]) -> None:
    """Write a block into a folder, which is made if need be; of an existing folder only the four files are replaced.

    Each file is written under a temporary name, flushed to the disk and then renamed: none is ever seen half written.
    Raises BlockFolderError if the folder cannot be written or an id cannot stand in a text file.
    """
    folder = Path(path)
    _check_ids(folder, block)
    texts = {name: _csv_text(COLUMNS[name], columns) for name, columns in _columns(block).items()}
    unique = secrets.token_hex(4)
    temporary = {folder / f"{name}.csv": folder / f".{name}.csv.{unique}.tmp" for name in texts}
    with _one_line(folder):
        folder.mkdir(parents=True, exist_ok=True)
        try:
            for file, text in zip(temporary.values(), texts.values(), strict=True):
                _write(file, text)
            for file, written in temporary.items():
                written.replace(file)
        finally:
            for file in temporary.values():
                file.unlink(missing_ok=True)


def _cameras(table: CsvTable) -> tuple[Camera, ...]:
    table.index("camera_id")
    values = np.stack([table.numbers(name) for name in INTERIOR], axis=1).tolist()
    return tuple(Camera(name, *row) for name, row in zip(table.columns["camera_id"], values, strict=True))


def _images(table: CsvTable, cameras: CsvTable) -> Images:
    table.index("image_id")
    positions = [table.numbers(name, may_be_empty=True) for name in POSITIONS]
    return Images(
        table.columns["image_id"],
        _lookup(table, "camera_id", cameras),
        np.stack([*positions, *(_radians(table, name) for name in ANGLES)], axis=1),
    )


def _points(table: CsvTable) -> Points:
    table.index("point_id")
    roles = table.columns["role"]
    for row, role in enumerate(roles):
        if role not in ROLES:
            raise table.error(f"{shown(role)} is no role, allowed are {', '.join(ROLES)}", row, "role")
    return Points(
        table.columns["point_id"],
        np.array(roles),
        np.stack([table.numbers(name, may_be_empty=True) for name in COORDINATES], axis=1),
        np.stack([table.numbers(name, may_be_empty=True) for name in SIGMAS], axis=1),
    )


def _observations(table: CsvTable, images: CsvTable, points: CsvTable) -> ImageObservations:
    x, y, sigma_x, sigma_y = (table.numbers(name) for name in COLUMNS["observations"][2:])
    return ImageObservations(
        _lookup(table, "image_id", images),
        _lookup(table, "point_id", points),
        np.stack([x, y], axis=1),
        np.stack([sigma_x, sigma_y], axis=1),
    )


def _radians(table: CsvTable, column: str) -> Floats:
    table.numbers(column, may_be_empty=True)  # refuses what is not a number, with its place
    return np.array([radians_of(text.strip()) for text in table.columns[column]])


def _lookup(table: CsvTable, column: str, other: CsvTable) -> Indices:
    """The rows of another table that a column of ids names; its ids have the same column name there."""
    rows = other.index(column)
    names = table.columns[column]
    found = np.array([rows.get(name, -1) for name in names], dtype=np.intp)
    if (found < 0).any():
        row = int(np.argmin(found))
        raise table.error(f"{shown(names[row])} is not in {other.path.name}", row, column)
    return found


def _columns(block: Block) -> dict[str, list[Iterable[Any]]]:
    """The columns of every file, in the order of its header."""
    images, points, observations = block.images, block.points, block.observations
    camera_ids = block.camera_ids
    return {
        "cameras": [camera_ids, *([float(getattr(c, name)) for c in block.cameras] for name in INTERIOR)],
        "images": [
            images.ids,
            [camera_ids[i] for i in images.camera.tolist()],
            *_number_columns(images.exterior[:, :3]),
            *(map(degrees_text, column) for column in images.exterior[:, 3:].T.tolist()),
        ],
        "points": [points.ids, points.role.tolist(), *_number_columns(points.coordinates, points.sigma)],
        "observations": [
            [images.ids[i] for i in observations.image.tolist()],
            [points.ids[i] for i in observations.point.tolist()],
            *_number_columns(observations.xy, observations.sigma),
        ],
    }


def _number_columns(*arrays: Floats) -> Iterator[list[float | str]]:
    """The columns of arrays (n, ...), NaN as an empty text; csv writes a float with the digits of its repr."""
    for column in np.concatenate(arrays, axis=1).T.tolist():
        yield ["" if value != value else value for value in column]


def _csv_text(header: Sequence[str], columns: Iterable[Iterable[Any]]) -> str:
    file = io.StringIO(newline="")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(zip(*columns, strict=True))
    return file.getvalue()


def _check_ids(folder: Path, block: Block) -> None:
    """Refuse an id that would not come back from the file."""
    ids = {"cameras": block.camera_ids, "images": block.images.ids, "points": block.points.ids}
    for table, names in ids.items():
        for row, name in enumerate(names):
            if len(name) > LONGEST_ID or UNWRITABLE.search(name):
                reason = f"{shown(name)} cannot be written: NUL, CR, a lone surrogate or over {LONGEST_ID} characters"
                raise BlockFolderError(folder / f"{table}.csv", reason, row + 2, COLUMNS[table][0])


def _write(file: Path, text: str) -> None:
    with file.open("xb") as stream:  # x: never through a link that stands there
        stream.write(text.encode())
        stream.flush()
        os.fsync(stream.fileno())


@contextmanager
def _one_line(folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise BlockFolderError(folder, f"cannot be written: {os.strerror(error.errno or 0)}") from error
