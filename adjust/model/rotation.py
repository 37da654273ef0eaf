"""Rotation matrices of the exterior orientation and their derivatives.

R = R1(omega) R2(phi) R3(kappa) rotates the camera frame into the object frame (docs/conventions.md). At phi = +-90
degrees omega and kappa are one rotation. An image that looks nearly along the object's X axis is therefore reckoned
with other names of the object axes, Y, Z, X for X, Y, Z: there its angles are far from that place. Which images these
are is said by `renamed` (m); their angles are unknowns only, people see those of the true axes.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from simfield.block import Floats

Flags = npt.NDArray[np.bool_]
STEEP = 0.966
"""the sine of phi, 75 degrees, from which on an image is reckoned with renamed axes"""
BACK, FORTH = [2, 0, 1], [1, 2, 0]
"""rows of R by the true axes, of one by Y, Z, X; and the other way"""
GIMBAL = 1e-9
"""the least |cos phi| that the angles of people are told apart by: nearer to 90 degrees their standard deviations are
those of this place, huge"""


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


def rotation_matrices(angles: Floats, renamed: Flags | None = None) -> Floats:
    """R (m, 3, 3), camera to object, for omega, phi, kappa (m, 3) in radians."""
    (r1, r2, r3), _ = _axis_rotations(angles)
    return _by_true_axes(np.asarray(r1 @ r2 @ r3), renamed)


def rotation_derivatives(angles: Floats, renamed: Flags | None = None) -> tuple[Floats, Floats]:
    """R (m, 3, 3) and dR (3, m, 3, 3), its derivatives by omega, phi, kappa."""
    (r1, r2, r3), (d1, d2, d3) = _axis_rotations(angles)
    derivatives = (_by_true_axes(d, renamed) for d in (d1 @ r2 @ r3, r1 @ d2 @ r3, r1 @ r2 @ d3))
    return _by_true_axes(np.asarray(r1 @ r2 @ r3), renamed), np.stack(list(derivatives))


def _by_true_axes(rotation: Floats, renamed: Flags | None) -> Floats:
    if renamed is not None and renamed.any():
        rotation[renamed] = rotation[renamed][:, BACK]
    return rotation


def angles_of(rotation: Floats, renamed: Flags | None = None) -> Floats:
    """omega, phi, kappa (m, 3) of R = R1(omega) R2(phi) R3(kappa), |phi| <= 90 degrees, by renamed axes where they are.

    At phi = +-90 degrees, where omega and kappa are one rotation, omega is 0.
    """
    r = rotation.copy()
    if renamed is not None and renamed.any():
        r[renamed] = r[renamed][:, FORTH]
    sine = np.clip(r[:, 0, 2], -1.0, 1.0)
    # the arc sine loses half the digits near 90 degrees
    angles = np.column_stack(
        [
            np.arctan2(-r[:, 1, 2], r[:, 2, 2]),
            np.where(np.abs(sine) < STEEP, np.arcsin(sine), np.arctan2(sine, np.hypot(r[:, 1, 2], r[:, 2, 2]))),
            np.arctan2(-r[:, 0, 1], r[:, 0, 0]),
        ]
    )
    locked = np.hypot(r[:, 1, 2], r[:, 2, 2]) < GIMBAL
    angles[locked, 0] = 0.0
    angles[locked, 2] = np.arctan2(r[locked, 1, 0], r[locked, 1, 1])
    return angles


def turns_of(angles: Floats, renamed: Flags | None = None) -> Floats:
    """(m, 3, 3): in the columns the small rotation about the object axes that a change of each angle is."""
    _, phi, _ = (column for column in angles.T)
    rotation = rotation_matrices(angles)
    (first, _, _), _ = _axis_rotations(angles)
    turns = np.zeros((len(phi), 3, 3))
    turns[:, 0, 0] = 1.0
    turns[:, :, 1], turns[:, :, 2] = first[:, :, 1], rotation[:, :, 2]
    return _by_true_axes(turns, renamed)


def angles_by_angles(angles: Floats, renamed: Flags) -> Floats:
    """(m, 3, 3): the derivatives of the angles of people by those that are unknowns; unity where no axis is renamed."""
    found = np.tile(np.eye(3), (len(angles), 1, 1))
    if renamed.any():
        own = rotation_matrices(angles[renamed], np.ones(int(renamed.sum()), dtype=bool))
        told = angles_of(own)
        near = np.pi / 2.0 - GIMBAL
        told[:, 1] = np.clip(told[:, 1], -near, near)
        found[renamed] = np.linalg.solve(turns_of(told), turns_of(angles[renamed], renamed[renamed]))
    return found


def steep(angles: Floats) -> Flags:
    """(m): the images whose phi is so near to 90 degrees that their axes are to be renamed."""
    return np.asarray(np.abs(rotation_matrices(angles)[:, 0, 2]) > STEEP)
