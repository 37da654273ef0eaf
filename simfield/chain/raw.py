"""The measured file: what a surveyor has before any reduction. Machine coordinates, marks, certificates, heights.

    cameras.csv, images.csv, points.csv    as in a block folder
    settings.csv       image_id, kind (point | fiducial | reseau), id, setting, time, x_mm, y_mm, in the machine's frame
    marks.csv          camera_id, kind, id, x_mm, y_mm, calibrated positions
    heights.csv        image_id, camera_m, ground_m, flying heights above sea level, as the altimeter gave them
    machine.csv        scale_x_ppm, scale_y_ppm, non_orthogonality_ppm of the comparator
    certificates.csv   camera_id, radius_mm, d45_um, d135_um, d225_um, d315_um, radial distortion, if any
    sigmas.csv         image_id, sigma_mm, the standard deviation that the adjustment is told

time runs from 0 to 1 in the session of an image; fiducials are set at its start and at its end.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from simfield import block_folder
from simfield.block import Block, Floats, ImageObservations, Images, Indices
from simfield.csv_table import BlockFolderError, CsvTable, read_table
from simfield.simulate import World
from simfield.simulate import _points as given_points
from simfield.streams import stream

if TYPE_CHECKING:
    from simfield.chain.measure import Prepared

COLUMNS: dict[str, tuple[str, ...]] = {
    "settings": ("image_id", "kind", "id", "setting", "time", "x_mm", "y_mm"),
    "marks": ("camera_id", "kind", "id", "x_mm", "y_mm"),
    "heights": ("image_id", "camera_m", "ground_m"),
    "machine": ("scale_x_ppm", "scale_y_ppm", "non_orthogonality_ppm"),
    "certificates": ("camera_id", "radius_mm", "d45_um", "d135_um", "d225_um", "d315_um"),
    "sigmas": ("image_id", "sigma_mm"),
}
BLOCK_TABLES = ("cameras", "images", "points")


@dataclass(frozen=True, eq=False)
class Raw:
    """block: cameras, images and points, its observations the means of the settings in the machine's frame.

    settings (k, s, 2) and time (k) of the image points in the order of the block's observations; mark_image, mark,
    mark_time (f) and mark_settings (f, s, 2) of all settings of marks; mark_ids and mark_kinds (M) name the marks,
    calibrated gives (M, 2) mm for each camera; heights (m, 2) of camera and ground, m; machine: scale x, scale y and
    non-orthogonality, ppm; certificates: radii (r) mm and distortions (4, r) um of cameras that have one.
    """

    block: Block
    settings: Floats
    time: Floats
    mark_image: Indices
    mark: Indices
    mark_time: Floats
    mark_settings: Floats
    mark_ids: tuple[str, ...]
    mark_kinds: tuple[str, ...]
    calibrated: Mapping[str, Floats]
    heights: Floats
    machine: tuple[float, float, float]
    certificates: Mapping[str, tuple[Floats, Floats]]

    @classmethod
    def of(cls, prepared: Prepared, settings: Floats, kept: Any, point: Indices, trial: int) -> Raw:
        """The measured file of a trial: kept (k) what was measured, point (k) under which name."""
        world, chain, k = prepared.world, prepared.chain, prepared.count
        block = _frame(world, trial)
        o = block.observations
        means = settings.mean(axis=1)
        observations = ImageObservations(o.image[kept], point[kept], means[:k][kept], o.sigma[kept])
        fiducials, crosses = len(chain.marks.fiducial_positions()), len(chain.marks.reseau_positions())
        air, machine = chain.air, chain.comparator
        height = world.exterior[:, 2] + air.altimeter_sigma_m * stream(world.seed, "altimeter").standard_normal(
            len(world.plan)
        )
        ground = np.full(len(height), float(np.mean(world.field.coordinates[:, 2])))
        return cls(
            block=Block(block.cameras, block.images, block.points, observations),
            settings=settings[:k][kept],
            time=prepared.time[:k][kept],
            mark_image=prepared.image[k:],
            mark=prepared.mark[k:],
            mark_time=prepared.time[k:],
            mark_settings=settings[k:],
            mark_ids=(*(f"f{i + 1}" for i in range(fiducials)), *(f"r{i + 1}" for i in range(crosses))),
            mark_kinds=("fiducial",) * fiducials + ("reseau",) * crosses,
            calibrated={c.camera_id: calibrated_marks(world, prepared, c.camera_id) for c in block.cameras},
            heights=np.column_stack([height, ground]),
            machine=(*machine.scale_ppm, machine.non_orthogonality_ppm),
            certificates={
                lens.camera: (np.array(lens.radial.radius_mm), np.atleast_2d(lens.radial.distortion_um))
                for lens in chain.lenses
                if lens.radial is not None
            },
        )


def _frame(world: World, trial: int) -> Block:
    """Cameras, approximate orientations and given points of a trial, with image coordinates yet to be measured."""
    plan = world.plan
    camera_ids = [c.camera_id for c in world.scenario.cameras]
    assumed = world.scenario.noise.assumed_sigma_mm(plan.camera_ids)[world.image]
    return Block(
        tuple(c.as_block_camera() for c in world.scenario.cameras),
        Images(plan.image_ids, np.array([camera_ids.index(c) for c in plan.camera_ids]), world.start),
        given_points(world, trial),
        ImageObservations(world.image, world.point, world.distorted, np.column_stack([assumed, assumed])),
    )


def calibrated_marks(world: World, prepared: Prepared, camera_id: str) -> Floats:
    """(M, 2) mm: the positions of a camera's marks as its certificate gives them."""
    marks = prepared.chain.marks
    true = np.concatenate([marks.fiducial_positions(), marks.reseau_positions()])
    error = stream(world.seed, "mark calibration", camera_id).standard_normal(true.shape)
    return np.asarray(true + marks.calibration_um / 1000.0 * error)


def write_raw(raw: Raw, path: str | os.PathLike[str]) -> None:
    """Write the measured file into a folder, which is made if need be. Raises BlockFolderError."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        columns = block_folder._columns(raw.block)
        for name in BLOCK_TABLES:
            _write(folder / f"{name}.csv", block_folder._csv_text(block_folder.COLUMNS[name], columns[name]))
        for name, rows in _rows(raw).items():
            columns_of = list(zip(*rows, strict=True)) or [()] * len(COLUMNS[name])
            if rows:
                _write(folder / f"{name}.csv", block_folder._csv_text(COLUMNS[name], columns_of))
    except OSError as error:
        raise BlockFolderError(folder, f"cannot be written: {os.strerror(error.errno or 0)}") from error


def _write(path: Path, text: str) -> None:
    path.write_text(text, encoding="utf-8")


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
    tables = {name: read_table(folder / f"{name}.csv", block_folder.COLUMNS[name]) for name in BLOCK_TABLES}
    has_certificates = (folder / "certificates.csv").exists()
    needed = [name for name in COLUMNS if name != "certificates" or has_certificates]
    own = {name: read_table(folder / f"{name}.csv", COLUMNS[name]) for name in needed}
    cameras = block_folder._cameras(tables["cameras"])
    images = block_folder._images(tables["images"], tables["cameras"])
    points = block_folder._points(tables["points"])
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
    values = np.stack([table.numbers(name) for name in COLUMNS["certificates"][1:]], axis=1)
    cameras = np.array(table.columns["camera_id"])
    return {c: (values[cameras == c, 0], values[cameras == c, 1:].T) for c in dict.fromkeys(table.columns["camera_id"])}
