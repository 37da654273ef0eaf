"""A block as a folder of CSV files, and back, without losing a bit: four that every block has, others where further
observations were made (simfield.files.further_files).

Every float is written with the digits that read as the same float, angles in degrees (simfield.files.degrees), NaN as
an empty field. What each column means, its unit and what an empty field says: docs/conventions.md. Other files in the
folder are neither read nor touched.
"""

from __future__ import annotations

import csv
import io
import os
import re
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
    ImageObservations,
    Images,
    Points,
)
from simfield.files import further_files
from simfield.files.columns import ALL_FILES, BLOCK, FURTHER, INTERIOR
from simfield.files.csv_table import BlockFolderError, CsvTable, number_columns, read_table, shown
from simfield.files.degrees import degrees_text
from simfield.files.whole_files import settle, write_set

__all__ = ["BlockFolderError", "read_block", "write_block"]

POSITIONS, ANGLES = EXTERIOR[:3], EXTERIOR[3:]
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
    with one_line(folder):
        settle(folder)
    tables = {name: read_table(folder / f"{name}.csv", columns) for name, columns in BLOCK.items()}
    optional = further_files.read_tables(folder)
    try:
        return Block(
            camera_records(tables["cameras"]),
            image_table(tables["images"], tables["cameras"]),
            point_table(tables["points"]),
            _observations(tables["observations"], tables["images"], tables["points"]),
            further_files.further(folder, optional, tables),
        )
    except BlockError as error:
        raise (tables | optional)[error.table].error(error.reason, error.row, error.column) from error


def write_block(block: Block, path: str | os.PathLike[str]) -> None:
    """Write a block into a folder, which is made if need be.

    The files of a block take the places of what the folder held of another block, of a measured file or of a truth, all
    or none; what this block does not have does not survive. Other files stay. Raises BlockFolderError if the folder
    cannot be written, and if an id cannot stand in a text file.
    """
    folder = Path(path)
    contents = block_files(block, folder)
    with one_line(folder):
        write_set(folder, contents, ALL_FILES)


def block_files(block: Block, folder: Path) -> dict[str, bytes]:
    """The files of a block by their names. Raises BlockFolderError for an id that would not come back from its file."""
    _check_ids(folder, block)
    tables = {name: (BLOCK[name], columns) for name, columns in block_columns(block).items()}
    tables |= {name: (FURTHER[name], columns) for name, columns in further_files.columns(block).items()}
    return {f"{name}.csv": csv_text(header, columns).encode() for name, (header, columns) in tables.items()}


def camera_records(table: CsvTable) -> tuple[Camera, ...]:
    """The cameras of cameras.csv. Raises BlockFolderError."""
    table.index("camera_id")
    values = np.stack([table.numbers(name) for name in INTERIOR], axis=1).tolist()
    return tuple(Camera(name, *row) for name, row in zip(table.columns["camera_id"], values, strict=True))


def image_table(table: CsvTable, cameras: CsvTable) -> Images:
    """The images of images.csv. Raises BlockFolderError."""
    table.index("image_id")
    positions = [table.numbers(name, may_be_empty=True) for name in POSITIONS]
    return Images(
        table.columns["image_id"],
        table.rows_of("camera_id", cameras),
        np.stack([*positions, *(table.radians(name) for name in ANGLES)], axis=1),
    )


def point_table(table: CsvTable) -> Points:
    """The points of points.csv. Raises BlockFolderError."""
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
    x, y, sigma_x, sigma_y = (table.numbers(name) for name in BLOCK["observations"][2:])
    return ImageObservations(
        table.rows_of("image_id", images),
        table.rows_of("point_id", points),
        np.stack([x, y], axis=1),
        np.stack([sigma_x, sigma_y], axis=1),
    )


def block_columns(block: Block) -> dict[str, list[Iterable[Any]]]:
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


def csv_text(header: Sequence[str], columns: Iterable[Iterable[Any]]) -> str:
    """A table as the text of a CSV file."""
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


@contextmanager
def one_line(folder: Path) -> Iterator[None]:
    """An OSError as a BlockFolderError of one line."""
    try:
        yield
    except OSError as error:
        raise BlockFolderError(folder, f"cannot be written: {os.strerror(error.errno or 0)}") from error
