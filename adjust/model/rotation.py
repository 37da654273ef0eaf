"""Rotation matrices of the exterior orientation and their derivatives.

R = R1(omega) R2(phi) R3(kappa) rotates the camera frame into the object frame (docs/conventions.md).
"""

from __future__ import annotations

import numpy as np

from simfield.block import Floats


def _axis_rotations(angles: Floats) -> tuple[list[Floats], list[Floats]]:
    """The three elementary rotations of angles (m, 3), and each one's derivative, all (m, 3, 3)."""
    rotations, derivatives = [], []
    for axis in range(3):
        cos, sin = np.cos(angles[:, axis]), np.sin(angles[:, axis])
        j, k = (axis + 1) % 3, (axis + 2) % 3
        rotation = np.zeros((len(angles), 3, 3))
        rotation[:, axis, axis] = 1.0
        rotation[:, j, j] = rotation[:, k, k] = cos
        rotation[:, j, k], rotation[:, k, j] = -sin, sin
        derivative = np.zeros_like(rotation)
        derivative[:, j, j] = derivative[:, k, k] = -sin
        derivative[:, j, k], derivative[:, k, j] = -cos, cos
        rotations.append(rotation)
        derivatives.append(derivative)
    return rotations, derivatives


def rotation_matrices(angles: Floats) -> Floats:
    """R (m, 3, 3), camera to object, for omega, phi, kappa (m, 3) in radians."""
    (r1, r2, r3), _ = _axis_rotations(angles)
    return np.asarray(r1 @ r2 @ r3)


def rotation_derivatives(angles: Floats) -> tuple[Floats, Floats]:
    """R (m, 3, 3) and dR (3, m, 3, 3), its derivatives by omega, phi, kappa."""
    (r1, r2, r3), (d1, d2, d3) = _axis_rotations(angles)
    return np.asarray(r1 @ r2 @ r3), np.stack([d1 @ r2 @ r3, r1 @ d2 @ r3, r1 @ r2 @ d3])
