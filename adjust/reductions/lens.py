"""Known lens errors taken out: a certificate of four half-diagonals, decentering, tilt, interior orientation.

As everywhere, measured = ideal + d(measured): what is subtracted is reckoned from the measured place.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from adjust.reductions.reduced_points import Reduced
from simfield.block import Floats

TO_HARMONICS = np.array(
    [[0.25, 0.25, 0.25, 0.25], [0.5, 0.0, -0.5, 0.0], [0.0, 0.5, 0.0, -0.5], [0.25, -0.25, 0.25, -0.25]]
)
"""mean, cosine, sine and cosine of twice the angle that go through the values on four half-diagonals"""


def radial(xy: Floats, radius_mm: Floats, distortion_um: Floats) -> Reduced:
    """Radial distortion by a certificate: radii (r) mm, distortions (4, r) um along the half-diagonals at 45, 135,
    225 and 315 degrees, or (1, r) their mean; a natural cubic spline through the centre along each.

    Raises ValueError for points beyond the last radius.
    """
    r = np.hypot(*xy.T)
    if r.size and r.max() > radius_mm[-1]:
        raise ValueError(f"a point at {r.max():.3f} mm lies beyond the certificate, which ends at {radius_mm[-1]:g} mm")
    along = half_diagonals(radius_mm, distortion_um)(r)
    # cosine and sine of the angle from the first half-diagonal, without the angle itself
    safe = np.where(r > 0.0, r, 1.0)
    cosine = (xy[:, 0] + xy[:, 1]) / (np.sqrt(2.0) * safe)
    sine = (xy[:, 1] - xy[:, 0]) / (np.sqrt(2.0) * safe)
    harmonics = np.column_stack([np.ones_like(r), cosine, sine, cosine**2 - sine**2])
    amount = np.sum(harmonics * (along @ TO_HARMONICS.T), axis=1)
    return Reduced.by(xy, xy * (1.0 - amount / safe)[:, None])


def half_diagonals(radius_mm: Floats, distortion_um: Floats) -> CubicSpline:
    """The distortion along the four half-diagonals, mm, over the radius: natural cubic splines through the centre."""
    curves, nodes = np.atleast_2d(distortion_um), np.asarray(radius_mm, dtype=float)
    if nodes[0] > 0.0:
        nodes, curves = np.append(0.0, nodes), np.column_stack([np.zeros(len(curves)), curves])
    four = np.broadcast_to(curves, (4, curves.shape[1]))
    return CubicSpline(nodes, 1e-3 * four.T, bc_type="natural")


def decentering(xy: Floats, p1: float, p2: float) -> Reduced:
    """Decentering as by Brown 1966: dx = p1 (r^2 + 2x^2) + 2 p2 xy, dy = p2 (r^2 + 2y^2) + 2 p1 xy."""
    x, y = xy[:, 0], xy[:, 1]
    dx = p1 * (3.0 * x * x + y * y) + 2.0 * p2 * x * y
    dy = p2 * (3.0 * y * y + x * x) + 2.0 * p1 * x * y
    return Reduced.by(xy, xy - np.stack([dx, dy], axis=1))


def tilt(xy: Floats, about_x_deg: float, about_y_deg: float, c_mm: float) -> Reduced:
    """The image plane turned back: it was turned about x first, then about y."""
    a, b = np.radians([about_x_deg, about_y_deg])
    turned = np.array([[np.cos(b), 0.0, np.sin(b)], [0.0, 1.0, 0.0], [-np.sin(b), 0.0, np.cos(b)]]) @ np.array(
        [[1.0, 0.0, 0.0], [0.0, np.cos(a), -np.sin(a)], [0.0, np.sin(a), np.cos(a)]]
    )
    ray = np.column_stack([xy, np.full(len(xy), -c_mm)]) @ turned
    return Reduced.by(xy, -c_mm * ray[:, :2] / ray[:, 2:])


def displaced(
    xy: Floats, principal_point_mm: tuple[float, float], principal_distance_mm: float, c_mm: float
) -> Reduced:
    """The true interior orientation, given as true minus calibrated, exchanged for the calibrated one."""
    centred = xy - np.asarray(principal_point_mm)
    return Reduced.by(xy, centred * (c_mm / (c_mm + principal_distance_mm)))
