"""Which of the visible points were measured.

A published block has an exact number of image points. The points that the comparator operator did not measure are
drawn, camera by camera, with a chance that grows with the distance from the image centre, where targets are dim,
oblique and close to the frame; no point falls below a number of rays in any camera.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from simfield.block import Floats, Indices
from simfield.random import stream

Flags = npt.NDArray[np.bool_]


class CountError(ValueError):
    """The published number of image points cannot be reached."""


@dataclass(frozen=True)
class PointCount:
    """Image points of one camera: of the main points alone, and of all points."""

    main: int
    total: int

    def __post_init__(self) -> None:
        if not 0 <= self.main <= self.total:
            raise ValueError(f"main {self.main} and total {self.total} must be 0 <= main <= total")


@dataclass(frozen=True)
class Measurement:
    """What is measured of what can be seen.

    A point has to lie margin_mm inside the film's edge. missing_share of the visible points is not measured, or, for
    a camera named in counts, as many as leave exactly these counts. The chance to be missed grows with the image
    radius to the power edge_preference (0: all alike). min_rays is the number of rays in each camera that the
    omission leaves. The main points are the central points of all groups but those of unused_groups.
    """

    margin_mm: float = 0.0
    missing_share: float = 0.0
    counts: Mapping[str, PointCount] = field(default_factory=dict)
    edge_preference: float = 2.0
    min_rays: int = 3
    unused_groups: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.margin_mm < 0.0 or self.edge_preference < 0.0 or self.min_rays < 2:
            raise ValueError("needed are margin_mm >= 0, edge_preference >= 0 and min_rays >= 2")
        if not 0.0 <= self.missing_share < 1.0:
            raise ValueError(f"missing_share {self.missing_share:g} is not allowed, it is a share from 0 to below 1")


@dataclass(frozen=True, eq=False)
class Rays:
    """Rays from images to points: image (k), point (k) and the radius (k) in mm of the image point."""

    image: Indices
    point: Indices
    radius_mm: Floats


def measured_rays(
    measurement: Measurement,
    rays: Rays,
    camera_ids: tuple[str, ...],
    image_ids: tuple[str, ...],
    main: Flags,
    seed: int,
) -> Flags:
    """(k): the rays that are measured. camera_ids and image_ids (m) name the images, main (n) flags the main points.

    Raises CountError where a count of the measurement cannot be reached.
    """
    kept = np.ones(len(rays.image), dtype=bool)
    order = _order_of_omission(measurement, rays, image_ids, len(main), seed)
    camera_of_ray = np.array(camera_ids)[rays.image]
    for camera_id in dict.fromkeys(camera_ids):
        own = camera_of_ray == camera_id
        left = np.bincount(rays.point[own], minlength=len(main))
        for name, kind in (("main", main[rays.point]), ("other", ~main[rays.point])):
            visible = own & kind
            wanted = _wanted(measurement, camera_id, name, int(visible.sum()))
            for ray in order[visible[order]]:
                if kept[visible].sum() == wanted:
                    break
                if left[rays.point[ray]] > measurement.min_rays:
                    kept[ray] = False
                    left[rays.point[ray]] -= 1
            _check_reached(camera_id, name, int(visible.sum()), int(kept[visible].sum()), wanted)
    return kept


def _order_of_omission(measurement: Measurement, rays: Rays, image_ids: tuple[str, ...], n: int, seed: int) -> Indices:
    """Rays in the order in which they are missed: weighted, not replaced (Efraimidis and Spirakis 2006)."""
    chance = np.stack([stream(seed, "omission", i).random(n) for i in image_ids])[rays.image, rays.point]
    weight = np.maximum(rays.radius_mm, 1e-3) ** measurement.edge_preference
    # log(u)/w ranks as u^(1/w); 1 - u lies in (0, 1] and keeps the logarithm finite
    return np.argsort(-np.log(1.0 - chance) / weight, kind="stable")


def _wanted(measurement: Measurement, camera_id: str, name: str, visible: int) -> int:
    count = measurement.counts.get(camera_id)
    if count is None:
        return visible - round(measurement.missing_share * visible)
    return count.main if name == "main" else count.total - count.main


def _check_reached(camera_id: str, name: str, visible: int, kept: int, wanted: int) -> None:
    if visible < wanted:
        raise CountError(f"camera {camera_id!r} sees {visible} image points of {name} points, needed are {wanted}")
    if kept > wanted:
        raise CountError(
            f"camera {camera_id!r}: {kept} image points of {name} points are left, only {wanted} are wanted"
        )
