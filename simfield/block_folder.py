"""A block as a folder of CSV files, and back, without losing a bit: four that every block has, others where further
observations were made (simfield.further_files).

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

from simfield import further_files
from simfield.block import (
    COORDINATES,
    EXTERIOR,
    ROLES,
    SIGMAS,
    Block,
    BlockError,
    Camera,
    ImageObservations,
    Images,
    Points,
)
from simfield.csv_table import BlockFolderError, CsvTable, number_columns, read_table, shown
from simfield.degrees import degrees_text

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
    optional = further_files.read_tables(folder)
    try:
        return Block(
            _cameras(tables["cameras"]),
            _images(tables["images"], tables["cameras"]),
            _points(tables["points"]),
            _observations(tables["observations"], tables["images"], tables["points"]),
            further_files.further(folder, optional, tables),
        )
    except BlockError as error:
        raise (tables | optional)[error.table].error(error.reason, error.row, error.column) from error


def write_block(block: Block, path: str | os.PathLike[str]) -> None:
    """Write a block into a folder, which is made if need be; of an existing folder only the block's files are replaced.

    Each file is written under a temporary name, flushed to the disk and then renamed: none is ever seen half written.
    Raises BlockFolderError if the folder cannot be written, if an id cannot stand in a text file, and where a file of
    further observations stands that this block does not have: it would be read with the block.
    """
    folder = Path(path)
    _check_ids(folder, block)
    texts = {name: _csv_text(COLUMNS[name], columns) for name, columns in _columns(block).items()}
    further_columns = further_files.columns(block)
    further_files.refuse_strangers(folder, further_columns)
    texts |= {name: _csv_text(further_files.COLUMNS[name], columns) for name, columns in further_columns.items()}
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
        table.rows_of("camera_id", cameras),
        np.stack([*positions, *(table.radians(name) for name in ANGLES)], axis=1),
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
        table.rows_of("image_id", images),
        table.rows_of("point_id", points),
        np.stack([x, y], axis=1),
        np.stack([sigma_x, sigma_y], axis=1),
    )


def _columns(block: Block) -> dict[str, list[Iterable[Any]]]:
    """The columns of every file, in the order of its header."""
    images, points, observations = block.images, block.points, block.observations
    camera_ids = block.camera_ids
    return {
        "cameras": [camera_ids, *([float(getattr(c, name)) for c in block.cameras] for name in INTERIOR)],
        "images": [
            images.ids,
            [camera_ids[i] for i in images.camera.tolist()],
            *number_columns(images.exterior[:, :3]),
            *(map(degrees_text, column) for column in images.exterior[:, 3:].T.tolist()),
        ],
        "points": [points.ids, points.role.tolist(), *number_columns(points.coordinates, points.sigma)],
        "observations": [
            [images.ids[i] for i in observations.image.tolist()],
            [points.ids[i] for i in observations.point.tolist()],
            *number_columns(observations.xy, observations.sigma),
        ],
    }


def _csv_text(header: Sequence[str], columns: Iterable[Iterable[Any]]) -> str:
    file = io.StringIO(newline="")
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(zip(*columns, strict=True))
    return file.getvalue()


def _check_ids(folder: Path, block: Block) -> None:
    """Refuse an id that would not come back from the file."""
    ids = {
        ("cameras", "camera_id"): block.camera_ids,
        ("images", "image_id"): block.images.ids,
        ("points", "point_id"): block.points.ids,
        ("strips", "strip_id"): block.further.strips.ids,
        ("ap_priors", "parameter"): block.further.ap_priors.names,
    }
    for (table, column), names in ids.items():
        for row, name in enumerate(names):
            if len(name) > LONGEST_ID or UNWRITABLE.search(name):
                reason = f"{shown(name)} cannot be written: NUL, CR, a lone surrogate or over {LONGEST_ID} characters"
                raise BlockFolderError(folder / f"{table}.csv", reason, row + 2, column)


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
