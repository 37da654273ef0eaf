"""Systematic effects of lens, film and air, in physical form.

An effect's `displacement(xy)` is d in measured = ideal + d(measured): the distortion contained in the measurement, in
mm, at the measured coordinates xy (n, 2) in mm, reckoned from the fiducial centre; r^2 = x^2 + y^2. Effects on one
image add up. Coefficients are literal, in powers of mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal, Protocol

import numpy as np

from simfield.block import Floats
from simfield.disturbances.kinds import OneOf

EARTH_RADIUS_M = 6_371_000.0
SEA_KELVIN, LAPSE, TROPOPAUSE_M = 288.15, 0.0065, 11_000.0
GRAVITY, GAS = 9.80665, 287.05287
SEA_REFRACTIVITY = 277.9e-6
LAYERS = 24
"""Gauss nodes between camera and ground"""


class Effect(Protocol):
    """Anything with a displacement. A test may bring its own; only the effects of this module can be written to a
    file.
    """

    def displacement(self, xy_mm: Floats) -> Floats:
        """(n, 2) mm at the measured coordinates (n, 2) mm."""
        ...


@dataclass(frozen=True)
class RadialPolynomial:
    """Radial-symmetric lens distortion with its second zero at r0: x [k1 (r^2-r0^2) + k2 (r^4-r0^4) + k3 (r^6-r0^6)].

    Source: Brown 1971; the second zero as in Mauelshagen 1980, 3.1.
    """

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0
    r0_mm: float = 100.0
    kind: Literal["radial-polynomial"] = "radial-polynomial"

    def displacement(self, xy_mm: Floats) -> Floats:
        s, s0 = np.sum(xy_mm**2, axis=1), self.r0_mm**2
        bracket = self.k1 * (s - s0) + self.k2 * (s**2 - s0**2) + self.k3 * (s**3 - s0**3)
        return np.asarray(xy_mm * bracket[:, None])


@dataclass(frozen=True)
class RadialTable:
    """Radial-symmetric distortion as a calibration certificate gives it: radii in mm, distortions in um.

    Between the nodes runs the natural cubic spline through (0, 0); its second derivative vanishes there, so that the
    distortion is an odd, twice differentiable function through the centre. Beyond the last radius nobody has measured:
    displacement raises ValueError there.
    """

    radius_mm: tuple[float, ...]
    distortion_um: tuple[float, ...]
    kind: Literal["radial-table"] = "radial-table"

    def __post_init__(self) -> None:
        if len(self.radius_mm) != len(self.distortion_um) or not self.radius_mm:
            raise ValueError("radius_mm and distortion_um need the same number of entries, at least one")
        if self.radius_mm[0] < 0.0 or any(b <= a for a, b in zip(self.radius_mm, self.radius_mm[1:], strict=False)):
            raise ValueError("radius_mm must rise from 0 or above")
        if self.radius_mm[0] == 0.0 and (self.distortion_um[0] != 0.0 or len(self.radius_mm) == 1):
            raise ValueError("the distortion at radius 0 is 0, and the table needs a radius beyond it")

    @property
    def reach_mm(self) -> float:
        """The largest radius, beyond which nobody has measured."""
        return self.radius_mm[-1]

    @cached_property
    def _nodes(self) -> tuple[Floats, Floats]:
        skip = 1 if self.radius_mm[0] == 0.0 else 0
        return np.array([0.0, *self.radius_mm[skip:]]), np.array([0.0, *self.distortion_um[skip:]]) / 1000.0

    @cached_property
    def _curvature(self) -> Floats:
        """Second derivatives at the nodes, 1/mm."""
        r, d = self._nodes
        h, slope = np.diff(r), np.diff(d) / np.diff(r)
        system = np.eye(len(r))
        right = np.zeros(len(r))
        for i in range(1, len(r) - 1):
            system[i, i - 1 : i + 2] = h[i - 1], 2.0 * (h[i - 1] + h[i]), h[i]
            right[i] = 6.0 * (slope[i] - slope[i - 1])
        return np.asarray(np.linalg.solve(system, right))

    def distortion_mm(self, r_mm: Floats) -> Floats:
        """The radial distortion (n) in mm at radii (n) in mm. Raises ValueError beyond the table."""
        r, d = self._nodes
        if r_mm.size and r_mm.max() > r[-1]:
            raise ValueError(f"radius {r_mm.max():.3f} mm lies beyond the distortion table, which ends at {r[-1]:g} mm")
        i = np.clip(np.searchsorted(r, r_mm, side="right") - 1, 0, len(r) - 2)
        h, m, t = np.diff(r)[i], self._curvature, r_mm - r[i]
        slope = (d[i + 1] - d[i]) / h - h * (2.0 * m[i] + m[i + 1]) / 6.0
        return np.asarray(d[i] + t * (slope + t * (m[i] / 2.0 + t * (m[i + 1] - m[i]) / (6.0 * h))))

    def displacement(self, xy_mm: Floats) -> Floats:
        return along_radius(xy_mm, self.distortion_mm(np.hypot(xy_mm[:, 0], xy_mm[:, 1])))


@dataclass(frozen=True)
class Decentering:
    """Decentering of the lens elements: dx = p1 (r^2 + 2x^2) + p2 2xy, dy = p1 2xy + p2 (r^2 + 2y^2). Source: Brown
    1966.
    """

    p1: float = 0.0
    p2: float = 0.0
    kind: Literal["decentering"] = "decentering"

    def displacement(self, xy_mm: Floats) -> Floats:
        x, y = xy_mm.T
        s, xy2 = x**2 + y**2, 2.0 * x * y
        return np.column_stack([self.p1 * (s + 2.0 * x**2) + self.p2 * xy2, self.p1 * xy2 + self.p2 * (s + 2.0 * y**2)])


@dataclass(frozen=True)
class FilmAffine:
    """Uniform film deformation (affinity and shear): dx = a x + b y, dy = c x + d y."""

    a: float = 0.0
    b: float = 0.0
    c: float = 0.0
    d: float = 0.0
    kind: Literal["film-affine"] = "film-affine"

    def displacement(self, xy_mm: Floats) -> Floats:
        return np.asarray(xy_mm @ np.array([[self.a, self.c], [self.b, self.d]]))


@dataclass(frozen=True)
class FilmPolynomial:
    """Film deformation of second and third degree: dx_xy2 is the coefficient of x y^2 in dx, and so on."""

    dx_x2: float = 0.0
    dx_xy: float = 0.0
    dx_y2: float = 0.0
    dx_x3: float = 0.0
    dx_x2y: float = 0.0
    dx_xy2: float = 0.0
    dx_y3: float = 0.0
    dy_x2: float = 0.0
    dy_xy: float = 0.0
    dy_y2: float = 0.0
    dy_x3: float = 0.0
    dy_x2y: float = 0.0
    dy_xy2: float = 0.0
    dy_y3: float = 0.0
    kind: Literal["film-polynomial"] = "film-polynomial"

    def displacement(self, xy_mm: Floats) -> Floats:
        x, y = xy_mm.T
        monomials = np.column_stack([x**2, x * y, y**2, x**3, x**2 * y, x * y**2, y**3])
        dx = (self.dx_x2, self.dx_xy, self.dx_y2, self.dx_x3, self.dx_x2y, self.dx_xy2, self.dx_y3)
        dy = (self.dy_x2, self.dy_xy, self.dy_y2, self.dy_x3, self.dy_x2y, self.dy_xy2, self.dy_y3)
        return np.asarray(monomials @ np.array([dx, dy]).T)


@dataclass(frozen=True)
class UnflatFilm:
    """Film off its plane: radial by (x/r) q, (y/r) q with q = b5 xy + b6 x^3 + b7 x^2 y + b8 x y^2 + b9 y^3.

    It is 0 at r = 0. Source: Brown 1976, as in Mauelshagen 1980, 3.3.
    """

    b5: float = 0.0
    b6: float = 0.0
    b7: float = 0.0
    b8: float = 0.0
    b9: float = 0.0
    kind: Literal["unflat-film"] = "unflat-film"

    def displacement(self, xy_mm: Floats) -> Floats:
        x, y = xy_mm.T
        q = self.b5 * x * y + self.b6 * x**3 + self.b7 * x**2 * y + self.b8 * x * y**2 + self.b9 * y**3
        return along_radius(xy_mm, q)


@dataclass(frozen=True)
class Refraction:
    """Atmospheric refraction of a vertical photograph: rays traced through the layers of the standard atmosphere.

    Heights above sea level, m. In flat layers n(z) sin(t) is the same at all heights (Snell), so a ray that arrives at
    the angle t from the nadir comes from the mean of its tangents over the layers; the point lies outward by the rest.
    Source: ISO 2533 (the ICAO atmosphere), and n - 1 = 277.9e-6 at 15 degrees C, 1013.25 hPa and 0.55 um (Edlen 1966),
    proportional to the density of dry air.
    """

    camera_height_m: float
    ground_height_m: float
    c_mm: float
    kind: Literal["refraction"] = "refraction"

    def displacement(self, xy_mm: Floats) -> Floats:
        nodes, weights = np.polynomial.legendre.leggauss(LAYERS)
        middle, half = (self.camera_height_m + s * self.ground_height_m for s in (1.0, -1.0))
        heights = 0.5 * (middle + half * nodes)
        q = refractive_index(np.array([self.camera_height_m])) / refractive_index(heights)
        tangent_squared = np.sum(xy_mm**2, axis=1) / self.c_mm**2
        share = (q / np.sqrt(1.0 + tangent_squared[:, None] * (1.0 - q**2))) @ (0.5 * weights)
        return np.asarray(xy_mm * (1.0 - share)[:, None])


def refractive_index(height_m: Floats) -> Floats:
    """n of dry air in the standard atmosphere, at heights (k) above sea level, m, to 20 km."""
    low = np.minimum(height_m, TROPOPAUSE_M)
    kelvin = SEA_KELVIN - LAPSE * low
    density = (kelvin / SEA_KELVIN) ** (GRAVITY / (GAS * LAPSE) - 1.0)
    above = np.exp(-GRAVITY * (height_m - low) / (GAS * kelvin))
    return np.asarray(1.0 + SEA_REFRACTIVITY * density * above)


@dataclass(frozen=True)
class EarthCurvature:
    """Earth curvature under a vertical photograph, in a plane frame: inward by H r^3/(2 R c^2), H above ground."""

    height_above_ground_m: float
    c_mm: float
    kind: Literal["earth-curvature"] = "earth-curvature"

    def displacement(self, xy_mm: Floats) -> Floats:
        factor = self.height_above_ground_m / (2.0 * EARTH_RADIUS_M * self.c_mm**2)
        return np.asarray(-factor * xy_mm * np.sum(xy_mm**2, axis=1)[:, None])


EFFECTS: tuple[type[Any], ...] = (
    RadialPolynomial,
    RadialTable,
    Decentering,
    FilmAffine,
    FilmPolynomial,
    UnflatFilm,
    Refraction,
    EarthCurvature,
)
"""The effects that a file can hold, told apart by their `kind`."""


@dataclass(frozen=True)
class EffectOn:
    """An effect and what it acts on: a camera (its lens), a flight (its film cassette) or one image.

    None is no restriction; where several are named, an image has to fit them all.
    """

    effect: Annotated[Effect, OneOf(*EFFECTS)]
    camera: str | None = None
    flight: str | None = None
    image: str | None = None

    def acts_on(self, camera_id: str, flight_id: str, image_id: str) -> bool:
        """Whether the effect acts on an image."""
        return self.camera in (None, camera_id) and self.flight in (None, flight_id) and self.image in (None, image_id)


def along_radius(xy_mm: Floats, amount_mm: Floats) -> Floats:
    """(n, 2): amount (n) along the radius at xy (n, 2); 0 at the centre, which has no direction."""
    r = np.hypot(xy_mm[:, 0], xy_mm[:, 1])
    return np.asarray(xy_mm * np.divide(amount_mm, r, out=np.zeros_like(r), where=r > 0.0)[:, None])
