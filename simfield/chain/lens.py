"""The lens by its certificate and mounting: four half-diagonals, decentering, tilt, displaced interior orientation."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from simfield.block import Floats
from simfield.disturbances import Decentering, RadialTable, along_radius, measured_from_ideal

HALF_DIAGONALS_DEG = (45.0, 135.0, 225.0, 315.0)


@dataclass(frozen=True)
class RadialCertificate:
    """Radial distortion measured along the four half-diagonals of the format, at 45, 135, 225 and 315 degrees.

    radius_mm (r) from 0 or above; distortion_um (4, r). Between the half-diagonals the distortion follows the
    trigonometric interpolation of four values: mean, first harmonic, and half of the second. Source: calibration
    certificates of survey lenses give four half-diagonals, and often only their mean.
    """

    radius_mm: tuple[float, ...]
    distortion_um: tuple[tuple[float, ...], ...]

    def __post_init__(self) -> None:
        if len(self.distortion_um) != len(HALF_DIAGONALS_DEG):
            raise ValueError(f"a certificate has four half-diagonals, found {len(self.distortion_um)}")
        assert self._tables

    @cached_property
    def _tables(self) -> tuple[RadialTable, ...]:
        return tuple(RadialTable(self.radius_mm, curve) for curve in self.distortion_um)

    @property
    def mean(self) -> RadialTable:
        """The mean of the half-diagonals, as certificates report it."""
        curves = np.mean(self.distortion_um, axis=0)
        return RadialTable(self.radius_mm, tuple(float(v) for v in curves))

    def displacement(self, xy_mm: Floats) -> Floats:
        """(n, 2) mm at xy (n, 2) mm. Raises ValueError beyond the last radius."""
        r = np.hypot(xy_mm[:, 0], xy_mm[:, 1])
        curves = np.stack([table.distortion_mm(r) for table in self._tables])
        angle = np.arctan2(xy_mm[:, 1], xy_mm[:, 0]) - np.deg2rad(HALF_DIAGONALS_DEG[0])
        a, b, c, d = curves
        mean, twice = (a + b + c + d) / 4.0, (a - b + c - d) / 4.0
        once = 0.5 * (a - c) * np.cos(angle) + 0.5 * (b - d) * np.sin(angle)
        return along_radius(xy_mm, mean + once + twice * np.cos(2.0 * angle))


@dataclass(frozen=True)
class Lens:
    """What the lens of a camera and its mounting do, in this order: distortion, tilt, displaced interior orientation.

    tilt_deg: rotations of the image plane about its x and y axis (aircraft window, lens mount). principal_point_mm and
    principal_distance_mm are true minus calibrated. source says where the numbers come from.
    """

    camera: str
    radial: RadialCertificate | RadialTable | None = None
    decentering: Decentering | None = None
    tilt_deg: tuple[float, float] = (0.0, 0.0)
    principal_point_mm: tuple[float, float] = (0.0, 0.0)
    principal_distance_mm: float = 0.0
    source: str = ""

    def distort(self, xy_mm: Floats, c_mm: float) -> Floats:
        """(n, 2) mm: where ideal points (n, 2) mm come to lie; c_mm is the calibrated principal distance."""
        if self.radial is not None or self.decentering is not None:
            xy_mm = measured_from_ideal(xy_mm, self._displacement)
        if any(self.tilt_deg):
            xy_mm = tilted(xy_mm, self.tilt_deg, c_mm)
        return np.asarray(xy_mm * (1.0 + self.principal_distance_mm / c_mm) + np.array(self.principal_point_mm))

    def _displacement(self, xy_mm: Floats) -> Floats:
        d = np.zeros_like(xy_mm)
        for effect in (self.radial, self.decentering):
            if effect is not None:
                d += effect.displacement(xy_mm)
        return d


def tilted(xy_mm: Floats, tilt_deg: tuple[float, float], c_mm: float) -> Floats:
    """(n, 2) mm: the images of the same rays in a plane that is turned about x, then about y."""
    about_x, about_y = np.deg2rad(tilt_deg)
    ray = np.column_stack([xy_mm, np.full(len(xy_mm), -c_mm)])
    y = ray[:, 1] * np.cos(about_x) - ray[:, 2] * np.sin(about_x)
    z = ray[:, 1] * np.sin(about_x) + ray[:, 2] * np.cos(about_x)
    x = ray[:, 0] * np.cos(about_y) + z * np.sin(about_y)
    z = z * np.cos(about_y) - ray[:, 0] * np.sin(about_y)
    return np.column_stack([-c_mm * x / z, -c_mm * y / z])
