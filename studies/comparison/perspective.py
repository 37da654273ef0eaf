"""The perspective reduction of a distortion field: the camera tilt that it contains is taken out.

Turn a camera by the small angles phi about its y axis and omega about its x axis. A ray with image point (x, y) has
the direction (x, y, -c); the turned camera sees it at x' = -c p_x / p_z, y' = -c p_y / p_z with p = (I + [a]_x)(x, y,
-c) and a = (omega, -phi, 0), which to first order moves the image point by

    dx = (c + x^2/c) phi + (xy/c) omega
    dy = (xy/c) phi      + (c + y^2/c) omega.

The constant part c phi, c omega cannot be told from a shift of the principal point, and over flat ground not from a
shift of the projection centre either. Decentering distortion a5 (r^2 + 2x^2), a5 2xy is half such a tilt: with phi =
2 c a5 it is that tilt, less the shift 2 c^2 a5, plus a5 (r^2, 0). So what an adjustment of vertical images over flat
ground finds as decentering contains an arbitrary tilt (Brown 1966, Decentering distortion of lenses: the tilt of a
thin prism), and the two angles and the two shifts are taken out by least squares over the format, as in Mauelshagen
1980, figures 2d and 3d, after Wester-Ebbinghaus 1980, Optik 55.

The four functions span (x^2, xy), (xy, y^2), (1, 0), (0, 1) whatever c is: the reduced field does not depend on c, only
the angles do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simfield.block import Floats


@dataclass(frozen=True, eq=False)
class PerspectiveReduction:
    """A field (k, 2) without the tilt it contained, in the unit of the field given.

    With a field in mm: phi and omega in radians, shift (2) in mm.
    """

    field: Floats
    phi: float
    omega: float
    shift: Floats


def tilt_terms(xy: Floats, c: float) -> Floats:
    """(k, 2, 2): the displacement of image points xy (k, 2), mm, for phi and omega of 1 rad, to first order, mm."""
    x, y = xy.T
    terms = np.empty((len(xy), 2, 2))
    terms[:, 0, 0], terms[:, 1, 0] = c + x**2 / c, x * y / c
    terms[:, 0, 1], terms[:, 1, 1] = x * y / c, c + y**2 / c
    return terms


def perspective_reduction(xy: Floats, field: Floats, c: float) -> PerspectiveReduction:
    """Fit tilt and shift of a camera with principal distance c, mm, to a field (k, 2) at xy (k, 2); take them out."""
    shift = np.broadcast_to(np.eye(2), (len(xy), 2, 2))
    design = np.concatenate([tilt_terms(xy, c), shift], axis=2).reshape(-1, 4)
    scale = np.linalg.norm(design, axis=0)
    fitted, *_ = np.linalg.lstsq(design / scale, field.ravel(), rcond=None)
    fitted = fitted / scale
    reduced = field - (design @ fitted).reshape(field.shape)
    return PerspectiveReduction(reduced, float(fitted[0]), float(fitted[1]), fitted[2:])
