"""Start values: orientations as given, or by resection from known points; points by intersection of rays.

A rough start is enough; the adjustment decides what is right.
"""

from __future__ import annotations

import numpy as np

from adjust.model import Unknowns, rotation_matrices
from adjust.normals import add_rays
from adjust.observations import ImagePoints
from adjust.solution.pose_choice import hypotheses, settled
from adjust.status import CHECK_START
from simfield.block import Block, Floats

NARROW = 1e-6
"""share of the weakest direction at which rays count as parallel"""
NEAR = 0.87
"""cosine of 30 degrees: a ray that misses the approximate coordinates of its point by more says nothing of them"""


class NoStartError(ValueError):
    """No start value could be found for something that is named."""


def values(unknowns: Unknowns, image_points: ImagePoints, place: int = 0, given: bool = True) -> Floats:
    """The working vector x to start from; additional parameters start at zero. Raises NoStartError.

    place: where images without orientation have several poses, 0 starts from those that agree best, 1 from the next.
    given: whether the orientations of the block are taken, else all are made.
    """
    block = unknowns.block
    exterior = block.images.exterior.copy() if given else np.full((len(block.images), 6), np.nan)
    exterior[:, :3] -= unknowns.origin
    points = np.where((block.points.role == "check")[:, None], np.nan, block.points.coordinates - unknowns.origin)
    _complete(exterior, points, image_points, place)
    x = np.concatenate([exterior.ravel(), np.zeros(unknowns.orientation - exterior.size), points.ravel()])
    x[unknowns.places] = points.ravel()
    return x


def _complete(exterior: Floats, points: Floats, image_points: ImagePoints, place: int) -> None:
    """Fill the gaps of exterior (m, 6) and points (n, 3) in place, in turns until nothing is missing."""
    block = image_points.unknowns.block
    on_level = not np.isnan(exterior[:, 0]).any()
    while True:
        _intersect(exterior, points, image_points, on_level)
        missing = [int(i) for i in np.flatnonzero(np.isnan(exterior[:, 0]))]
        if not missing and on_level:
            break
        oriented = _orient(missing, exterior, points, image_points, place, on_level)
        place = 0 if oriented else place
        if not oriented and on_level:
            raise NoStartError(
                f"image {block.images.ids[missing[0]]} has no approximate orientation, "
                "and fewer than three points with known coordinates from which one could be made"
            )
        # points are laid on the ground only where nothing else is left: oblique rays meet it anywhere
        on_level = not oriented
    _meet_again(exterior, points, image_points)
    _lay_on_rays(exterior, points, image_points)
    lost = np.isnan(points).any(axis=1)
    if lost.any():
        raise NoStartError(_lost(block, [int(i) for i in np.flatnonzero(lost)]))


def _orient(
    missing: list[int], exterior: Floats, points: Floats, image_points: ImagePoints, place: int, last: bool
) -> bool:
    """Give a pose to images that the known points leave one, else to those that another image settles."""
    poses = {i: found for i in missing if (found := hypotheses(i, points, image_points, last))}
    sure = {i: found[0] for i, found in poses.items() if len(found) == 1}
    for image, pose in (sure or (settled(poses, exterior, points, image_points, place) if poses else {})).items():
        exterior[image] = pose
    return bool(poses)


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


def _lay_on_rays(exterior: Floats, points: Floats, image_points: ImagePoints) -> None:
    """Points whose two or more rays do not meet in front of the cameras are laid on them, as far away as the others."""
    g = image_points
    station, direction = _rays(exterior, g)
    lost = np.isnan(points).any(axis=1)
    distance = np.linalg.norm(points[g.point] - station, axis=1)
    if not lost.any() or not np.isfinite(distance).any():
        return
    place = station + np.nanmedian(distance) * direction
    for point in np.flatnonzero(lost):
        rows = g.point == point
        if rows.sum() >= 2:
            points[point] = place[rows].mean(axis=0)


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
