"""The collinearity equations and their derivatives.

p = R^T (X - X0),  x = x0 - c p_x / p_z,  y = y0 - c p_y / p_z  (docs/conventions.md); a point in front of the camera
has p_z < 0. The simulator has its own projection (simfield.world.imaging); this module shares nothing with it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust.model.rotation import Flags, rotation_derivatives, rotation_matrices
from simfield.block import Floats, Indices


def project(
    exterior: Floats, interior: Floats, points: Floats, image: Indices, renamed: Flags | None = None
) -> tuple[Floats, Floats]:
    """Image coordinates xy (k, 2), mm, and depths -p_z (k), m, of points (k, 3) seen in the images `image` (k).

    exterior (m, 6) in m and rad, by renamed axes where `renamed` (m) says so (adjust.model.rotation); interior (m, 3)
    with c, x0, y0 in mm for every image. A depth < 0 lies behind the camera; at depth 0 the coordinates are infinite or
    NaN.
    """
    rotation = rotation_matrices(exterior[:, 3:], renamed)
    p = np.einsum("kij,ki->kj", rotation[image], points - exterior[image, :3])
    c, principal = interior[image, :1], interior[image, 1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        return principal - c * (p[:, :2] / p[:, 2:]), -p[:, 2]


@dataclass(frozen=True, eq=False)
class Projection:
    """Projected coordinates xy (k, 2), depth (k) and the derivatives of xy.

    by_exterior (k, 2, 6) for X0, Y0, Z0, omega, phi, kappa; by_point (k, 2, 3); by_interior (k, 2, 3) for c, x0, y0.
    """

    xy: Floats
    depth: Floats
    by_exterior: Floats
    by_point: Floats
    by_interior: Floats


def linearise(
    exterior: Floats, interior: Floats, points: Floats, image: Indices, renamed: Flags | None = None
) -> Projection:
    """The projection of `project` with its derivatives; same arguments."""
    rotation, derivatives = rotation_derivatives(exterior[:, 3:], renamed)
    ray = points - exterior[image, :3]
    p = np.einsum("kij,ki->kj", rotation[image], ray)
    c, principal = interior[image, :1], interior[image, 1:]
    ratio = p[:, :2] / p[:, 2:]
    by_p = np.zeros((len(image), 2, 3))
    by_p[:, 0, 0] = by_p[:, 1, 1] = -c[:, 0] / p[:, 2]
    by_p[:, :, 2] = c * ratio / p[:, 2:]
    by_point = by_p @ rotation[image].transpose(0, 2, 1)
    by_exterior = np.empty((len(image), 2, 6))
    by_exterior[:, :, :3] = -by_point
    for axis in range(3):
        p_by_angle = np.einsum("kij,ki->kj", derivatives[axis][image], ray)
        by_exterior[:, :, 3 + axis] = np.einsum("kij,kj->ki", by_p, p_by_angle)
    by_interior = np.zeros((len(image), 2, 3))
    by_interior[:, :, 0] = -ratio
    by_interior[:, 0, 1] = by_interior[:, 1, 2] = 1.0
    return Projection(principal - c * ratio, -p[:, 2], by_exterior, by_point, by_interior)
