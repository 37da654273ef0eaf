"""Further observations in a block folder: files that may be there or not, beside the four that every block has."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from simfield.block import (
    ATTITUDE,
    POSITION,
    SIGMA_ATTITUDE,
    SIGMA_POSITION,
    Block,
    Floats,
    Further,
    Indices,
    Lines,
    Priors,
    Stations,
    Strips,
)
from simfield.files.columns import FURTHER
from simfield.files.csv_table import BlockFolderError, CsvTable, number_columns, read_table
from simfield.files.degrees import degrees_text


def read_tables(folder: Path) -> dict[str, CsvTable]:
    """The tables that are there. Raises BlockFolderError for a defect of form."""
    files = {name: folder / f"{name}.csv" for name in FURTHER}
    return {name: read_table(path, FURTHER[name]) for name, path in files.items() if path.exists() or path.is_symlink()}


def further(folder: Path, tables: Mapping[str, CsvTable], block: Mapping[str, CsvTable]) -> Further:
    """What the tables say; `block` are the tables of the block itself. Raises BlockFolderError."""
    if "strips" in tables and "stations" not in tables:
        raise BlockFolderError(folder / "stations.csv", "is missing, strips.csv says something about its strips")
    points = block["points"]
    return Further(
        _strips(tables["strips"]) if "strips" in tables else Strips(),
        _stations(tables["stations"], tables.get("strips"), block["images"]) if "stations" in tables else Stations(),
        _lines(tables["distances"], points) if "distances" in tables else Lines(),
        _lines(tables["height_differences"], points) if "height_differences" in tables else Lines(),
        _priors(tables["ap_priors"], block["cameras"]) if "ap_priors" in tables else Priors(),
    )


def columns(block: Block) -> dict[str, list[Iterable[Any]]]:
    """The columns of the files that this block needs, in the order of their headers."""
    f, points = block.further, block.points.ids
    priors, prior_cameras = f.ap_priors, [block.camera_ids[i] for i in f.ap_priors.camera]
    found: dict[str, list[Iterable[Any]]] = {
        "strips": [f.strips.ids, f.strips.position, f.strips.attitude],
        "stations": _station_columns(block),
        "distances": _line_columns(f.distances, points),
        "height_differences": _line_columns(f.height_differences, points),
        "ap_priors": [prior_cameras, priors.names, *_numbers(priors.values, priors.sigma)],
    }
    return {name: each for name, each in found.items() if len(getattr(f, name))}


def _strips(table: CsvTable) -> Strips:
    table.index("strip_id")
    return Strips(table.columns["strip_id"], table.columns["position_bias"], table.columns["attitude_bias"])


def _stations(table: CsvTable, strips: CsvTable | None, images: CsvTable) -> Stations:
    def numbers(names: Iterable[str]) -> Floats:
        return np.stack([table.numbers(name, may_be_empty=True) for name in names], axis=1)

    def radians(names: Iterable[str]) -> Floats:
        return np.stack([table.radians(name) for name in names], axis=1)

    return Stations(
        table.rows_of("image_id", images),
        _strip_rows(table, strips),
        table.numbers("time_s", may_be_empty=True),
        numbers(POSITION),
        numbers(SIGMA_POSITION),
        radians(ATTITUDE),
        radians(SIGMA_ATTITUDE),
    )


def _strip_rows(table: CsvTable, strips: CsvTable | None) -> Indices:
    """The strip of every station, -1 where the field is empty."""
    names = table.columns["strip_id"]
    rows = {} if strips is None else strips.index("strip_id")
    found = np.array([-1 if not name else rows.get(name, -2) for name in names], dtype=np.intp)
    if (found == -2).any():
        row = int(np.argmin(found))
        raise table.error(
            f"{names[row]!r} is not in strips.csv; leave it empty where no bias is asked", row, "strip_id"
        )
    return found


def _lines(table: CsvTable, points: CsvTable) -> Lines:
    value = next(name for name in table.columns if name in ("distance_m", "height_difference_m"))
    return Lines(
        table.rows_of("from_point_id", points, "point_id"),
        table.rows_of("to_point_id", points, "point_id"),
        table.numbers(value),
        table.numbers("sigma_m"),
    )


def _priors(table: CsvTable, cameras: CsvTable) -> Priors:
    camera, names = table.rows_of("camera_id", cameras), table.columns["parameter"]
    return Priors(camera, names, table.numbers("value"), table.numbers("sigma"))


def _station_columns(block: Block) -> list[Iterable[Any]]:
    s, strips = block.further.stations, block.further.strips.ids
    angles = np.hstack([s.attitude, s.sigma_attitude])
    return [
        [block.images.ids[i] for i in s.image],
        ["" if i < 0 else strips[i] for i in s.strip],
        *number_columns(s.time_s[:, None], s.position, s.sigma_position),
        *(map(degrees_text, column) for column in angles.T.tolist()),
    ]


def _line_columns(lines: Lines, points: tuple[str, ...]) -> list[Iterable[Any]]:
    return [[points[i] for i in lines.start], [points[i] for i in lines.end], *_numbers(lines.values, lines.sigma)]


def _numbers(*arrays: Floats) -> Iterable[list[float | str]]:
    return number_columns(np.column_stack(arrays))
