"""Small blocks with a known truth, made without the product's simulator, which is itself one of the things under test.

The projection is scalar, typed from the nine elements of the rotation matrix as photogrammetry textbooks print them
(Kraus, Photogrammetry, vol. 2, appendix; omega primary, phi secondary, kappa tertiary), and shares no line with the
product. Angles in radians, object coordinates in metres, image coordinates in millimetres.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from adjust.ap_models.model import ApModel
from simfield.block.block import Block, Camera, Floats, ImageObservations, Images, Points

WW = Camera("ww", 152.91, 0.012, -0.008, 230.0, 230.0)
SWW = Camera("sww", 85.43, -0.006, 0.015, 230.0, 230.0)
SIGMA_MM = 0.004
"""standard deviation of an image coordinate"""
QUARTERS = (0.0, math.pi / 2, math.pi, -math.pi / 2)
"""the four headings of a calibration flight"""


def rotation(omega: float, phi: float, kappa: float) -> list[list[float]]:
    """The matrix from the camera to the object frame, element by element."""
    so, co = math.sin(omega), math.cos(omega)
    sp, cp = math.sin(phi), math.cos(phi)
    sk, ck = math.sin(kappa), math.cos(kappa)
    return [
        [cp * ck, -cp * sk, sp],
        [co * sk + so * sp * ck, co * ck - so * sp * sk, -so * cp],
        [so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp],
    ]


def project(camera: Camera, exterior: Sequence[float], point: Sequence[float]) -> tuple[float, float]:
    """x and y of one point in one image."""
    r = rotation(exterior[3], exterior[4], exterior[5])
    d = [point[i] - exterior[i] for i in range(3)]
    u, v, w = (r[0][j] * d[0] + r[1][j] * d[1] + r[2][j] * d[2] for j in range(3))
    return camera.x0_mm - camera.c_mm * u / w, camera.y0_mm - camera.c_mm * v / w


def distort(ideal: Floats, model: ApModel, coefficients: Floats) -> Floats:
    """The measured coordinates (k, 2) that satisfy measured = ideal + d(measured), to the last digits.

    Newton's method with the identity for the derivative of measured - d(measured): d' is about 1e-3, so every step wins
    three digits.
    """
    measured = ideal.copy()
    for _ in range(30):
        measured = ideal + model.basis(measured[:, 0], measured[:, 1]) @ coefficients
    return measured


@dataclass(frozen=True, eq=False)
class World:
    """A block, and what nobody tells the adjustment: exterior (m, 6), coordinates (n, 3), models and ap by camera."""

    block: Block
    exterior: Floats
    coordinates: Floats
    models: Mapping[str, ApModel]
    ap: Mapping[str, Floats]

    def started_at(self, exterior: Floats) -> World:
        """The same world with other approximate orientations; NaN rows for images without."""
        b = self.block
        return replace(
            self, block=Block(b.cameras, Images(b.images.ids, b.images.camera, exterior), b.points, b.observations)
        )

    def with_points(
        self, *, role: Sequence[str] | None = None, coordinates: Floats | None = None, sigma: Floats | None = None
    ) -> World:
        """The same world with another points table."""
        b, p = self.block, self.block.points
        points = Points(
            p.ids,
            p.role if role is None else np.asarray(role),
            p.coordinates if coordinates is None else coordinates,
            p.sigma if sigma is None else sigma,
        )
        return replace(self, block=Block(b.cameras, b.images, points, b.observations))

    def with_image_points(self, xy: Floats) -> World:
        return replace(self, block=self.block.replace_image_points(xy))

    def with_noise(self, rng: np.random.Generator) -> World:
        """Normal noise of the stated standard deviations on the image points, on those of this world."""
        o = self.block.observations
        return self.with_image_points(o.xy + o.sigma * rng.standard_normal(o.xy.shape))

    def controlled(self, ids: Sequence[str], sigma: Sequence[float] = (0.0, 0.0, 0.0)) -> World:
        """Exactly the points `ids` as control, with the true coordinates and sigma (NaN: coordinate unknown)."""
        p = self.block.points
        chosen = np.isin(p.ids, ids)
        assert chosen.sum() == len(ids), "a control point is missing from this world"
        coordinates = np.where(chosen[:, None] & np.isfinite(sigma), self.coordinates, np.nan)
        return self.with_points(
            role=np.where(chosen, "control", "tie").tolist(),
            coordinates=coordinates,
            sigma=np.where(chosen[:, None], np.asarray(sigma, dtype=float), np.nan),
        )


def quincunx(
    spacing_m: float = 500.0, relief_m: float = 40.0, per_group: int = 1, seed: int = 7
) -> dict[str, list[float]]:
    """5 x 5 groups 11..55 and the 4 x 4 between, 16..49; a, b, ... for further points of a group."""
    rng = np.random.default_rng(seed)
    field: dict[str, list[float]] = {}
    for row in range(5):
        for column in range(5):
            field[f"{row + 1}{column + 1}"] = [(column - 2) * spacing_m, (2 - row) * spacing_m, 0.0]
    for row in range(4):
        for column in range(4):
            field[f"{row + 1}{column + 6}"] = [(column - 1.5) * spacing_m, (1.5 - row) * spacing_m, 0.0]
    for name in list(field):
        field[name][2] = relief_m * float(rng.uniform(-1.0, 1.0))
        for extra in "abcdefgh"[: per_group - 1]:
            shift = rng.uniform(-12.0, 12.0, 3) * [1.0, 1.0, 0.1]
            field[name + extra] = [float(v) for v in np.add(field[name], shift)]
    return field


CONTROL = ("11", "15", "33", "51", "55")
"""corners and centre"""


def fly(
    camera: Camera, scale: float, headings: Sequence[float] = QUARTERS, tilt_rad: float = 0.02, seed: int = 3
) -> Floats:
    """(3 a strip, 6): strips of three images, 60 % overlap, the middle one over the field's centre."""
    rng = np.random.default_rng(seed)
    base = 0.4 * camera.width_mm / 1000.0 * scale
    images = []
    for heading in headings:
        for along in (-base, 0.0, base):
            position = [along * math.cos(heading), along * math.sin(heading), camera.c_mm / 1000.0 * scale]
            angles = np.add(rng.normal(0.0, tilt_rad, 3), [0.0, 0.0, heading])
            images.append([*np.add(position, rng.normal(0.0, 0.01 * position[2], 3) * (tilt_rad > 0.0)), *angles])
    return np.array(images)


def world(
    flights: Sequence[tuple[Camera, Floats]],
    field: Mapping[str, Sequence[float]],
    models: Mapping[str, ApModel] | None = None,
    ap: Mapping[str, Floats] | None = None,
    control: Sequence[str] = CONTROL,
    sigma_mm: float = SIGMA_MM,
    shift: Sequence[float] = (0.0, 0.0, 0.0),
) -> World:
    """Photograph `field` in all flights, noise-free, and state the true orientations as approximate ones.

    Every point within 110 mm of both axes is measured; points seen once are left out, control points stay.
    """
    cameras = tuple(camera for camera, _ in flights)
    exterior = np.vstack([images for _, images in flights])
    image_camera = np.repeat(np.arange(len(flights)), [len(images) for _, images in flights])
    names = list(field)
    rows = []
    for image, orientation in enumerate(exterior):
        camera = cameras[image_camera[image]]
        for point, name in enumerate(names):
            x, y = project(camera, orientation, field[name])
            if abs(x) < 110.0 and abs(y) < 110.0:
                rows.append((image, point, x, y))
    table = np.array(rows)
    point = table[:, 1].astype(int)
    seen = np.bincount(point, minlength=len(names))
    kept = np.array([n >= 2 or (n >= 1 and name in control) for n, name in zip(seen, names, strict=True)])
    table = table[kept[point]]
    image, point = table[:, 0].astype(int), (np.cumsum(kept) - 1)[table[:, 1].astype(int)]
    xy = table[:, 2:].copy()
    models, ap = dict(models or {}), dict(ap or {})
    for number, camera in enumerate(cameras):
        if camera.camera_id in ap:
            mine = image_camera[image] == number
            xy[mine] = distort(xy[mine], models[camera.camera_id], ap[camera.camera_id])
    ids = tuple(name for name, k in zip(names, kept, strict=True) if k)
    coordinates = np.array([field[name] for name in ids]) + shift
    exterior = np.add(exterior, [*shift, 0.0, 0.0, 0.0])
    is_control = np.isin(ids, control)
    points = Points(
        ids,
        np.where(is_control, "control", "tie"),
        np.where(is_control[:, None], coordinates, np.nan),
        np.where(is_control[:, None], np.zeros(3), np.nan),
    )
    numbers = [sum(image_camera[:i] == c) + 1 for i, c in enumerate(image_camera)]
    image_ids = tuple(f"{cameras[c].camera_id}-{n}" for c, n in zip(image_camera, numbers, strict=True))
    block = Block(
        cameras,
        Images(image_ids, image_camera, exterior),
        points,
        ImageObservations(image, point, xy, np.full(xy.shape, sigma_mm)),
    )
    return World(block, exterior, coordinates, models, ap)
