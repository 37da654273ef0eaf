"""A measured file as a folder of CSV files, and back.

cameras.csv, images.csv, points.csv    as in a block folder
settings.csv       image_id, kind (point | fiducial | reseau), id, setting, time, x_mm, y_mm, in the machine's frame
marks.csv          camera_id, kind, id, x_mm, y_mm, calibrated positions
heights.csv        image_id, camera_m, ground_m, flying heights above sea level, as the altimeter gave them
machine.csv        scale_x_ppm, scale_y_ppm, non_orthogonality_ppm of the comparator
certificates.csv   camera_id, radius_mm, d45_um, d135_um, d225_um, d315_um, radial distortion, if any
sigmas.csv         image_id, sigma_mm, the standard deviation that the adjustment is told
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from simfield.block import Block, Floats, ImageObservations, Indices, Raw
from simfield.files.block_folder import block_columns, camera_records, csv_text, image_table, one_line, point_table
from simfield.files.columns import ALL_FILES, BLOCK, RAW
from simfield.files.csv_table import BlockFolderError, CsvTable, read_table
from simfield.files.whole_files import settle, write_set

BLOCK_TABLES = ("cameras", "images", "points")


def write_raw(raw: Raw, path: str | os.PathLike[str]) -> None:
    """Write the measured file into a folder, which is made if need be. Raises BlockFolderError.

    Its files take the places of what the folder held of another measured file, of a block or of a truth, all or none.
    """
    folder = Path(path)
    contents = raw_files(raw)
    with one_line(folder):
        write_set(folder, contents, ALL_FILES)


def raw_files(raw: Raw) -> dict[str, bytes]:
    """The files of a measured file by their names."""
    columns = block_columns(raw.block)
    texts = {name: csv_text(BLOCK[name], columns[name]) for name in BLOCK_TABLES}
    texts |= {name: csv_text(RAW[name], zip(*rows, strict=True)) for name, rows in _rows(raw).items() if rows}
    return {f"{name}.csv": text.encode() for name, text in texts.items()}


def _rows(raw: Raw) -> dict[str, list[tuple[Any, ...]]]:
    ids, o = raw.block.images.ids, raw.block.observations
    settings: list[tuple[Any, ...]] = []
    for i, p, t, values in zip(
        o.image.tolist(), o.point.tolist(), raw.time.tolist(), raw.settings.tolist(), strict=True
    ):
        name = raw.block.points.ids[p]
        settings += [(ids[i], "point", name, s + 1, t, *xy) for s, xy in enumerate(values)]
    marks = zip(
        raw.mark_image.tolist(), raw.mark.tolist(), raw.mark_time.tolist(), raw.mark_settings.tolist(), strict=True
    )
    for i, m, t, values in marks:
        settings += [(ids[i], raw.mark_kinds[m], raw.mark_ids[m], s + 1, t, *xy) for s, xy in enumerate(values)]
    return {
        "settings": settings,
        "marks": [
            (camera, kind, name, *xy)
            for camera, places in raw.calibrated.items()
            for kind, name, xy in zip(raw.mark_kinds, raw.mark_ids, places.tolist(), strict=True)
        ],
        "heights": [(name, *row) for name, row in zip(ids, raw.heights.tolist(), strict=True)],
        "machine": [raw.machine],
        "certificates": [
            (camera, r, *curves)
            for camera, (radii, values) in raw.certificates.items()
            for r, curves in zip(radii.tolist(), np.broadcast_to(values, (4, len(radii))).T.tolist(), strict=True)
        ],
        "sigmas": list(zip(ids, _sigma_of_images(raw).tolist(), strict=True)),
    }


def _sigma_of_images(raw: Raw) -> Floats:
    sigma = np.full(len(raw.block.images), float(raw.block.observations.sigma.max()))
    sigma[raw.block.observations.image] = raw.block.observations.sigma[:, 0]
    return sigma


def read_raw(path: str | os.PathLike[str]) -> Raw:
    """The measured file in a folder. Raises BlockFolderError with file, row and column at the first defect."""
    folder = Path(path)
    with one_line(folder):
        settle(folder)
    tables = {name: read_table(folder / f"{name}.csv", BLOCK[name]) for name in BLOCK_TABLES}
    has_certificates = (folder / "certificates.csv").exists()
    needed = [name for name in RAW if name != "certificates" or has_certificates]
    own = {name: read_table(folder / f"{name}.csv", RAW[name]) for name in needed}
    cameras = camera_records(tables["cameras"])
    images = image_table(tables["images"], tables["cameras"])
    points = point_table(tables["points"])
    sigma = own["sigmas"].numbers("sigma_mm")[_place(own["sigmas"], "image_id", images.ids)]
    marks = own["marks"]
    first = marks.columns["camera_id"][0]
    count = marks.columns["camera_id"].count(first)
    positions = np.stack([marks.numbers("x_mm"), marks.numbers("y_mm")], axis=1)
    mark_ids, calibrated = marks.columns["id"][:count], {}
    for camera in dict.fromkeys(marks.columns["camera_id"]):
        rows = [i for i, name in enumerate(marks.columns["camera_id"]) if name == camera]
        if tuple(marks.columns["id"][i] for i in rows) != tuple(mark_ids):
            raise marks.error("has other marks than the first camera", rows[0], "camera_id")
        calibrated[camera] = positions[rows]
    heights = np.stack([own["heights"].numbers("camera_m"), own["heights"].numbers("ground_m")], axis=1)
    rows_of = _settings(own["settings"], images.ids, points.ids, mark_ids)
    image, what, time, values, is_point = rows_of
    observations = ImageObservations(
        image[is_point],
        what[is_point],
        values[is_point].mean(axis=1),
        np.repeat(sigma[image[is_point], None], 2, axis=1),
    )
    return Raw(
        Block(cameras, images, points, observations),
        values[is_point],
        time[is_point],
        image[~is_point],
        what[~is_point],
        time[~is_point],
        values[~is_point],
        tuple(mark_ids),
        tuple(marks.columns["kind"][:count]),
        calibrated,
        heights[_place(own["heights"], "image_id", images.ids)],
        (
            float(own["machine"].numbers("scale_x_ppm")[0]),
            float(own["machine"].numbers("scale_y_ppm")[0]),
            float(own["machine"].numbers("non_orthogonality_ppm")[0]),
        ),
        _certificates(own.get("certificates")),
    )


def _settings(
    table: CsvTable, images: tuple[str, ...], points: tuple[str, ...], marks: tuple[str, ...]
) -> tuple[Indices, Indices, Floats, Floats, Any]:
    """image (n), point or mark (n), time (n), settings (n, s, 2), and which are points, from the lines of the file."""
    names = {"point": points, "fiducial": marks, "reseau": marks}
    places = {kind: {name: i for i, name in enumerate(known)} for kind, known in names.items()}
    image_of = {name: i for i, name in enumerate(images)}
    number = table.numbers("setting").astype(int)
    count = int(number.max())
    image, what = np.empty(len(number), dtype=np.intp), np.empty(len(number), dtype=np.intp)
    columns = (table.columns[name] for name in ("image_id", "kind", "id"))
    for row, (image_id, kind, name) in enumerate(zip(*columns, strict=True)):
        if kind not in places:
            raise table.error(f"{kind!r} is no kind, allowed are {', '.join(names)}", row, "kind")
        if image_id not in image_of:
            raise table.error(f"{image_id!r} is not in images.csv", row, "image_id")
        if name not in places[kind]:
            raise table.error(f"{name!r} is not in {'points' if kind == 'point' else 'marks'}.csv", row, "id")
        if number[row] != row % count + 1:
            raise table.error(f"the settings of a place stand together, 1 to {count}", row, "setting")
        image[row], what[row] = image_of[image_id], places[kind][name]
    xy = np.stack([table.numbers("x_mm"), table.numbers("y_mm")], axis=1).reshape(-1, count, 2)
    is_point = np.array([kind == "point" for kind in table.columns["kind"]])[::count]
    return image[::count], what[::count], table.numbers("time")[::count], xy, is_point


def _place(table: CsvTable, column: str, ids: tuple[str, ...]) -> Indices:
    """The row of every id. Raises BlockFolderError for an id that is missing."""
    rows = table.index(column)
    for name in ids:
        if name not in rows:
            raise BlockFolderError(table.path, f"{name!r} is missing")
    return np.array([rows[name] for name in ids], dtype=np.intp)


def _certificates(table: CsvTable | None) -> dict[str, tuple[Floats, Floats]]:
    if table is None:
        return {}
    values = np.stack([table.numbers(name) for name in RAW["certificates"][1:]], axis=1)
    cameras = np.array(table.columns["camera_id"])
    return {c: (values[cameras == c, 0], values[cameras == c, 1:].T) for c in dict.fromkeys(table.columns["camera_id"])}
