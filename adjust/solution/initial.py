"""Start values: orientations as given or by a vertical image over known points, points by intersection of rays.

A rough start is enough; the adjustment decides what is right.
"""

from __future__ import annotations

import numpy as np

from adjust.model import Unknowns, rotation_matrices
from adjust.normals import add_rays
from adjust.observations import ImagePoints
from adjust.status import CHECK_START
from simfield.block import Block, Floats

NARROW = 1e-6
"""share of the weakest direction at which rays count as parallel"""


class NoStartError(ValueError):
    """No start value could be found for something that is named."""


def values(unknowns: Unknowns, image_points: ImagePoints) -> Floats:
    """The working vector x to start from; additional parameters start at zero. Raises NoStartError."""
    block = unknowns.block
    exterior = block.images.exterior.copy()
    exterior[:, :3] -= unknowns.origin
    points = np.where((block.points.role == "check")[:, None], np.nan, block.points.coordinates - unknowns.origin)
    _complete(exterior, points, image_points)
    x = np.concatenate([exterior.ravel(), np.zeros(unknowns.orientation - exterior.size), points.ravel()])
    x[unknowns.places] = points.ravel()
    return x


def _complete(exterior: Floats, points: Floats, image_points: ImagePoints) -> None:
    """Fill the gaps of exterior (m, 6) and points (n, 3) in place, in turns until nothing is missing."""
    block = image_points.unknowns.block
    while True:
        _intersect(exterior, points, image_points)
        missing = [int(i) for i in np.flatnonzero(np.isnan(exterior[:, 0]))]
        if not missing:
            break
        oriented = [i for i in missing if _orient_vertically(i, exterior, points, image_points)]
        if not oriented:
            raise NoStartError(
                f"image {block.images.ids[missing[0]]} has no approximate orientation, "
                "and fewer than three points with known coordinates from which one could be made"
            )
    lost = np.isnan(points).any(axis=1)
    if lost.any():
        raise NoStartError(_lost(block, [int(i) for i in np.flatnonzero(lost)]))


def _lost(block: Block, points: list[int]) -> str:
    point, more = points[0], f" (nor do those of {len(points) - 1} more points)" if len(points) > 1 else ""
    rays = int(block.rays[point])
    if rays < 2:
        return f"point {block.points.ids[point]} has no coordinates and {rays} ray{'s' * (rays != 1)}"
    return (
        f"the {rays} rays of point {block.points.ids[point]} do not meet in front of the cameras{more}; {CHECK_START}"
    )


def _rays(exterior: Floats, image_points: ImagePoints) -> tuple[Floats, Floats]:
    """Stations (k, 3) and unit directions (k, 3) of all rays, NaN for images without orientation."""
    g = image_points
    c, principal = g.interior[g.image, 0], g.interior[g.image, 1:]
    camera = np.column_stack([g.xy - principal, -c])
    rotation = rotation_matrices(exterior[:, 3:])
    direction = np.einsum("kij,kj->ki", rotation[g.image], camera)
    return exterior[g.image, :3], direction / np.linalg.norm(direction, axis=1, keepdims=True)


def _intersect(exterior: Floats, points: Floats, image_points: ImagePoints) -> None:
    """Fill unknown coordinates with the point nearest to all its rays; known coordinates stay.

    Where rays are too flat or meet behind a camera, the point is put at the height of the known points instead.
    """
    g = image_points
    station, direction = _rays(exterior, g)
    usable = np.isfinite(direction[:, 0]) & np.isnan(points[g.point]).any(axis=1)
    point, station, direction = g.point[usable], station[usable], direction[usable]
    matrix, right = np.zeros((len(points), 3, 3)), np.zeros((len(points), 3))
    add_rays(point, station, direction, matrix, right)
    rays = np.bincount(point, minlength=len(points))
    weakest = np.linalg.eigvalsh(matrix)[:, 0]
    meet = (rays >= 2) & (weakest > NARROW)
    found = np.full_like(points, np.nan)
    found[meet] = np.linalg.solve(matrix[meet], right[meet][:, :, None])[:, :, 0]
    behind = np.einsum("ki,ki->k", found[point] - station, direction) <= 0.0
    found[point[behind]] = np.nan
    level = points[:, 2][np.isfinite(points[:, 2])]
    if level.size:
        flat = ~np.isfinite(found[point][:, 0]) & (rays[point] >= 1) & (direction[:, 2] < -NARROW)
        distance = (np.median(level) - station[flat, 2]) / direction[flat, 2]
        on_level = station[flat] + distance[:, None] * direction[flat]
        found[point[flat][distance > 0.0]] = on_level[distance > 0.0]
    gaps = np.isnan(points)
    points[gaps] = found[gaps]


def _orient_vertically(image: int, exterior: Floats, points: Floats, image_points: ImagePoints) -> bool:
    """Start an image as a vertical one by a plane similarity from its points with known coordinates, three at least."""
    g = image_points
    rows = np.arange(g.starts[image], g.starts[image + 1])
    known = points[g.point[rows]]
    rows, known = rows[np.isfinite(known).all(axis=1)], known[np.isfinite(known).all(axis=1)]
    if len(rows) < 3:
        return False
    c, principal = g.interior[image, 0], g.interior[image, 1:]
    z_image = (g.xy[rows] - principal) @ [1.0, 1.0j]
    z_object = known[:, :2] @ [1.0, 1.0j]
    design = np.column_stack([z_image, np.ones(len(rows))])
    (turn, shift), *_ = np.linalg.lstsq(design, z_object, rcond=None)
    height = c * abs(turn) + known[:, 2].mean()
    exterior[image] = [shift.real, shift.imag, height, 0.0, 0.0, np.angle(turn)]
    return bool(abs(turn) > 0.0)
