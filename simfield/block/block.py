"""The block: what a surveyor hands over for adjustment, and nothing else.

This is the one data model shared by the simulator and the engine. It knows no file, no formula and no truth. Tables are
structures of arrays: row i of every array in a table belongs to the same image, point or observation.

Conventions (docs/conventions.md): object frame right-handed, metres, Z up; image frame x right, y up, origin at the
fiducial centre, millimetres; angles in radians; NaN marks an unknown value.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from simfield.block.camera import Camera as Camera
from simfield.block.checks import (
    BlockError as BlockError,
    Floats as Floats,
    Indices as Indices,
    check_ids,
    check_index,
    check_shape,
    freeze,
    refuse,
    refuse_weightless,
)
from simfield.block.further import Further

ROLES = ("control", "check", "tie")
EXTERIOR = ("X0_m", "Y0_m", "Z0_m", "omega_deg", "phi_deg", "kappa_deg")
COORDINATES = ("X_m", "Y_m", "Z_m")
SIGMAS = ("sigma_X_m", "sigma_Y_m", "sigma_Z_m")


@dataclass(frozen=True, eq=False)
class Images:
    """Images with their camera and exterior orientation.

    ids (m), camera (m) index into the block's cameras, exterior (m, 6) with X0, Y0, Z0 in metres and omega, phi,
    kappa in radians. In a block these are approximate values; a row may be NaN.
    """

    ids: tuple[str, ...]
    camera: Indices
    exterior: Floats

    def __post_init__(self) -> None:
        freeze(self, camera=np.intp, exterior=np.float64)

    def __len__(self) -> int:
        return len(self.ids)


@dataclass(frozen=True, eq=False)
class Points:
    """Object points: ids (n), role (n) in ROLES, coordinates (n, 3) and their standard deviations sigma (n, 3), m.

    A control coordinate with sigma 0 is fixed, with sigma > 0 an observation, with sigma NaN unknown (its coordinate,
    if any, is a start value). A check point is adjusted like a tie point; its coordinates are only compared.
    """

    ids: tuple[str, ...]
    role: npt.NDArray[np.str_]
    coordinates: Floats
    sigma: Floats

    def __post_init__(self) -> None:
        freeze(self, role=np.str_, coordinates=np.float64, sigma=np.float64)

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def fixed(self) -> npt.NDArray[np.bool_]:
        """(n, 3): control coordinates held fixed."""
        return np.asarray((self.role == "control")[:, None] & (self.sigma == 0.0))

    @property
    def weighted(self) -> npt.NDArray[np.bool_]:
        """(n, 3): control coordinates that enter as observations."""
        return np.asarray((self.role == "control")[:, None] & (self.sigma > 0.0))


@dataclass(frozen=True, eq=False)
class ImageObservations:
    """Measured image points: image (k) and point (k) indices, xy (k, 2) and standard deviations sigma (k, 2), mm."""

    image: Indices
    point: Indices
    xy: Floats
    sigma: Floats

    def __post_init__(self) -> None:
        freeze(self, image=np.intp, point=np.intp, xy=np.float64, sigma=np.float64)

    def __len__(self) -> int:
        return len(self.image)


@dataclass(frozen=True, eq=False)
class Block:
    """A photogrammetric block, validated when it is made and read-only afterwards.

    Tables of cameras, images (m), points (n) and image observations (k); they refer to each other by index. `rays` (n)
    counts. Raises BlockError with table, row and column at the first defect.
    """

    cameras: tuple[Camera, ...]
    images: Images
    points: Points
    observations: ImageObservations
    further: Further = field(default_factory=Further)
    """stations, distances, height differences and prior values, none by default"""
    rays: Indices = field(init=False, repr=False)
    """(n) number of images in which each point was measured"""

    def __post_init__(self) -> None:
        _check_cameras(self.cameras)
        _check_images(self.images, len(self.cameras))
        _check_points(self.points)
        _check_observations(self.observations, self.images, self.points)
        rays = np.bincount(self.observations.point, minlength=len(self.points)).astype(np.intp)
        rays.flags.writeable = False
        object.__setattr__(self, "rays", rays)
        _check_rays(self.points, rays)
        self.further.check(self.images.ids, self.points.ids, self.camera_ids)

    @property
    def camera_ids(self) -> tuple[str, ...]:
        """The ids of the cameras, in the order of `cameras`."""
        return tuple(c.camera_id for c in self.cameras)

    @property
    def image_camera(self) -> Indices:
        """(k): the camera index of every observation."""
        return self.images.camera[self.observations.image]

    def replace_image_points(self, xy: Floats) -> Block:
        """The same block with other image coordinates xy (k, 2), mm. Raises BlockError for another shape, or values
        that are not finite.
        """
        o = self.observations
        return replace(self, observations=ImageObservations(o.image, o.point, xy, o.sigma))

    def without(self, *tables: str) -> Block:
        """The same block without some of its further tables (simfield.block.further.TABLES), all if none is named.

        Raises KeyError for another name.
        """
        return replace(self, further=self.further.without(*tables))

    def select(
        self,
        *,
        cameras: Collection[str] | None = None,
        images: Collection[str] | None = None,
        points: Collection[str] | None = None,
    ) -> Block:
        """The sub-block of the named cameras, images and points; None keeps all.

        Points that are left without any observation are left out, and so are cameras without images. Further
        observations stay where all that they belong to is kept.
        Raises KeyError for a name that the block does not have.
        """
        camera_keep = _named(self.camera_ids, cameras, "camera")
        image_keep = _named(self.images.ids, images, "image") & camera_keep[self.images.camera]
        point_keep = _named(self.points.ids, points, "point")
        o = self.observations
        kept = image_keep[o.image] & point_keep[o.point]
        point_keep &= np.bincount(o.point[kept], minlength=len(self.points)) > 0
        camera_keep &= np.bincount(self.images.camera[image_keep], minlength=len(self.cameras)) > 0
        camera_at, image_at, point_at = (np.cumsum(k) - 1 for k in (camera_keep, image_keep, point_keep))
        return Block(
            tuple(c for c, k in zip(self.cameras, camera_keep, strict=True) if k),
            Images(
                tuple(i for i, k in zip(self.images.ids, image_keep, strict=True) if k),
                camera_at[self.images.camera[image_keep]],
                self.images.exterior[image_keep],
            ),
            Points(
                tuple(p for p, k in zip(self.points.ids, point_keep, strict=True) if k),
                self.points.role[point_keep],
                self.points.coordinates[point_keep],
                self.points.sigma[point_keep],
            ),
            ImageObservations(image_at[o.image[kept]], point_at[o.point[kept]], o.xy[kept], o.sigma[kept]),
            self.further.select(image_keep, point_keep, camera_keep),
        )


def _named(ids: tuple[str, ...], wanted: Collection[str] | None, kind: str) -> npt.NDArray[np.bool_]:
    if wanted is None:
        return np.ones(len(ids), dtype=bool)
    unknown = sorted(set(wanted) - set(ids))
    if unknown:
        raise KeyError(f"no {kind} named {unknown[0]!r} in this block")
    chosen = set(wanted)
    return np.array([i in chosen for i in ids], dtype=bool)


def _check_cameras(cameras: tuple[Camera, ...]) -> None:
    check_ids("cameras", [c.camera_id for c in cameras], "camera_id")
    columns = ("c_mm", "x0_mm", "y0_mm", "width_mm", "height_mm")
    values = np.array([[getattr(c, name) for name in columns] for c in cameras], dtype=float)
    refuse("cameras", ~np.isfinite(values), columns, values, "must be finite")
    positive = np.array([True, False, False, True, True])
    refuse("cameras", positive & (values <= 0.0), columns, values, "must be > 0")


def _check_images(images: Images, n_cameras: int) -> None:
    check_ids("images", images.ids, "image_id")
    check_shape("images", "camera", images.camera, (len(images),))
    check_shape("images", "exterior", images.exterior, (len(images), 6))
    check_index("images", images.camera, n_cameras, "camera_id")
    refuse("images", np.isinf(images.exterior), EXTERIOR, images.exterior, "must be finite or empty")
    started = np.isfinite(images.exterior)
    partial = started.any(axis=1) & ~started.all(axis=1)
    if partial.any():
        row = int(np.argmax(partial))
        column = EXTERIOR[int(np.argmin(started[row]))]
        raise BlockError("images", "is empty while others are given; give all six or none", row, column)
    attitude = np.where(started[:, 3:], np.abs(images.exterior[:, 3:]), 0.0)
    refuse("images", attitude > 4.0 * np.pi, EXTERIOR[3:], np.rad2deg(images.exterior[:, 3:]), "|angle| <= 720 degrees")


def _check_points(points: Points) -> None:
    n = len(points)
    check_ids("points", points.ids, "point_id")
    check_shape("points", "role", points.role, (n,))
    check_shape("points", "coordinates", points.coordinates, (n, 3))
    check_shape("points", "sigma", points.sigma, (n, 3))
    unknown = ~np.isin(points.role, ROLES)
    if unknown.any():
        row = int(np.argmax(unknown))
        raise BlockError("points", f"{str(points.role[row])!r} is no role, allowed are {', '.join(ROLES)}", row, "role")
    refuse("points", np.isinf(points.coordinates), COORDINATES, points.coordinates, "must be finite or empty")
    refuse("points", np.isinf(points.sigma), SIGMAS, points.sigma, "must be finite or empty")
    refuse("points", points.sigma < 0.0, SIGMAS, points.sigma, "must be >= 0 or empty")
    refuse_weightless("points", points.sigma, SIGMAS)
    control = (points.role == "control")[:, None]
    refuse(
        "points",
        control & np.isfinite(points.sigma) & np.isnan(points.coordinates),
        COORDINATES,
        points.coordinates,
        "a control coordinate with a sigma needs a value",
    )


def _check_observations(observations: ImageObservations, images: Images, points: Points) -> None:
    k = len(observations)
    if k == 0:
        raise BlockError("observations", "is empty")
    check_shape("observations", "image", observations.image, (k,))
    check_shape("observations", "point", observations.point, (k,))
    check_shape("observations", "xy", observations.xy, (k, 2))
    check_shape("observations", "sigma", observations.sigma, (k, 2))
    check_index("observations", observations.image, len(images), "image_id")
    check_index("observations", observations.point, len(points), "point_id")
    refuse("observations", ~np.isfinite(observations.xy), ("x_mm", "y_mm"), observations.xy, "must be finite")
    bad_sigma = ~(np.isfinite(observations.sigma) & (observations.sigma > 0.0))
    refuse("observations", bad_sigma, ("sigma_x_mm", "sigma_y_mm"), observations.sigma, "must be finite and > 0")
    refuse_weightless("observations", observations.sigma, ("sigma_x_mm", "sigma_y_mm"))
    pair = observations.image * len(points) + observations.point
    order = np.argsort(pair, kind="stable")
    twice = np.flatnonzero(np.diff(pair[order]) == 0)
    if twice.size:
        row = int(order[twice + 1].min())
        image, point = images.ids[observations.image[row]], points.ids[observations.point[row]]
        raise BlockError("observations", f"point {point!r} was already measured in image {image!r}", row, "point_id")


def _check_rays(points: Points, rays: Indices) -> None:
    few = (points.role != "control") & (rays < 2)
    if few.any():
        row = int(np.argmax(few))
        raise BlockError(
            "points",
            f"{points.role[row]} point {points.ids[row]!r} has {rays[row]} ray(s), at least two are needed",
            row,
            "point_id",
        )
