"""Start values: orientations as given, or by resection from known points; points by intersection of rays.

A rough start is enough; the adjustment decides what is right.
"""

from __future__ import annotations

import numpy as np

from adjust.model import Unknowns, angles_of, rotation_matrices
from adjust.normals import add_rays
from adjust.observations import ImagePoints
from adjust.solution.resection import resected
from adjust.status import CHECK_START
from simfield.block import Block, Floats

NARROW = 1e-6
"""share of the weakest direction at which rays count as parallel"""


NEAR = 0.87
"""cosine of 30 degrees: a ray that misses the approximate coordinates of its point by more says nothing of them"""


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
    on_level = not np.isnan(exterior[:, 0]).any()
    while True:
        _intersect(exterior, points, image_points, on_level)
        missing = [int(i) for i in np.flatnonzero(np.isnan(exterior[:, 0]))]
        if not missing and on_level:
            break
        # three points leave up to four poses, so images with more of them come first
        oriented = [i for i in missing if _orient(i, exterior, points, image_points, 4)]
        oriented = oriented or [i for i in missing if on_level and _orient(i, exterior, points, image_points, 3)]
        if not oriented and on_level:
            raise NoStartError(
                f"image {block.images.ids[missing[0]]} has no approximate orientation, "
                "and fewer than three points with known coordinates from which one could be made"
            )
        # points are laid on the ground only where nothing else is left: oblique rays meet it anywhere
        on_level = not oriented
    _meet_again(exterior, points, image_points)
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


def _intersect(exterior: Floats, points: Floats, image_points: ImagePoints, on_level: bool = True) -> None:
    """Fill unknown coordinates with the point nearest to all its rays; known coordinates stay.

    Where rays are too flat or meet behind a camera, the point is put at the height of the known points, if `on_level`.
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
    if level.size and on_level:
        flat = ~np.isfinite(found[point][:, 0]) & (rays[point] >= 1) & (direction[:, 2] < -NARROW)
        distance = (np.median(level) - station[flat, 2]) / direction[flat, 2]
        on_ground = station[flat] + distance[:, None] * direction[flat]
        found[point[flat][distance > 0.0]] = on_ground[distance > 0.0]
    gaps = np.isnan(points)
    points[gaps] = found[gaps]


def _meet_again(exterior: Floats, points: Floats, image_points: ImagePoints) -> None:
    """Intersect anew what is no control and lies behind a camera or far from its rays: an approximate value that is
    none, such as 0, 0, 0.
    """
    g, block = image_points, image_points.unknowns.block
    station, direction = _rays(exterior, g)
    ray = points[g.point] - station
    far = ~(np.einsum("ki,ki->k", ray, direction) > NEAR * np.linalg.norm(ray, axis=1))
    loose = np.isin(np.arange(len(points)), g.point[far]) & (block.points.role != "control")
    if loose.any():
        given = points[loose].copy()
        points[loose] = np.nan
        _intersect(exterior, points, g)
        still = np.isnan(points[loose]).any(axis=1)
        points[np.flatnonzero(loose)[still]] = given[still]


def _orient(image: int, exterior: Floats, points: Floats, image_points: ImagePoints, least: int) -> bool:
    """Start an image from its points with known coordinates, `least` or more: as a vertical one, or by resection,
    whichever leaves the smaller residuals.
    """
    g = image_points
    rows = np.arange(g.starts[image], g.starts[image + 1])
    known = points[g.point[rows]]
    rows, known = rows[np.isfinite(known).all(axis=1)], known[np.isfinite(known).all(axis=1)]
    if len(rows) < least:
        return False
    c, principal = g.interior[image, 0], g.interior[image, 1:]
    camera = np.column_stack([g.xy[rows] - principal, np.full(len(rows), -c)])
    candidates = _vertical(camera, known)
    for station, rotation in resected(camera / np.linalg.norm(camera, axis=1, keepdims=True), known):
        candidates.append(np.concatenate([station, angles_of(rotation[None])[0]]))
    if not candidates:
        return False
    exterior[image] = min(candidates, key=lambda each: _misfit(each, camera, known))
    return True


def _vertical(camera: Floats, known: Floats) -> list[Floats]:
    """The vertical image over known points (k, 3), by a plane similarity, seen along (k, 3) of the camera frame, mm."""
    z_image, z_object = camera[:, :2] @ [1.0, 1.0j], known[:, :2] @ [1.0, 1.0j]
    design = np.column_stack([z_image, np.ones(len(known))])
    (turn, shift), *_ = np.linalg.lstsq(design, z_object, rcond=None)
    height = -camera[0, 2] * abs(turn) + known[:, 2].mean()
    return [np.array([shift.real, shift.imag, height, 0.0, 0.0, np.angle(turn)])] if abs(turn) > 0.0 else []


def _misfit(exterior: Floats, camera: Floats, known: Floats) -> tuple[int, float]:
    """Points behind the camera, and the mean distance in the image, mm, by which known points are missed; of three
    points, which many poses fit, the tilt."""
    rotation = rotation_matrices(exterior[None, 3:])[0]
    seen = (known - exterior[:3]) @ rotation
    behind = int(np.sum(seen[:, 2] >= 0.0))
    if len(known) == 3 and not behind:
        return behind, float(1.0 - rotation[2, 2])
    with np.errstate(all="ignore"):
        missed = np.linalg.norm(camera[:, 2:] * seen[:, :2] / seen[:, 2:] - camera[:, :2], axis=1)
    return behind, float(missed.mean())
