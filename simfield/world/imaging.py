"""The simulator's own projection and visibility, by quaternions.

Written apart from the engine on purpose: an error that both shared would cancel and never be seen.

The unit quaternion q = q1(omega) q2(phi) q3(kappa) rotates camera to object. A point X seen from X0 lies at p = q* (X
- X0) q in the camera frame, and its ideal image is x = x0 - c p_x / p_z, y = y0 - c p_y / p_z. Points in front of the
camera have p_z < 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from simfield.block import Floats
from simfield.world.cameras import CameraModel


def quaternion_product(a: Floats, b: Floats) -> Floats:
    """Hamilton's product of quaternions (..., 4), scalar part first."""
    scalar = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    vector = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([scalar, vector], axis=-1)


def attitude_quaternion(angles: Floats) -> Floats:
    """(m, 4) quaternions, camera to object, of omega, phi, kappa (m, 3) in radians."""
    turns = np.zeros((3, len(angles), 4))
    for axis in range(3):
        turns[axis, :, 0] = np.cos(0.5 * angles[:, axis])
        turns[axis, :, 1 + axis] = np.sin(0.5 * angles[:, axis])
    return quaternion_product(quaternion_product(turns[0], turns[1]), turns[2])


def into_camera_frame(exterior: Floats, points: Floats) -> Floats:
    """(m, n, 3) points (n, 3) as seen in the camera frames of exterior (m, 6), metres."""
    q = attitude_quaternion(exterior[:, 3:])[:, None, :]
    rays = points[None, :, :] - exterior[:, None, :3]
    # q* v q for a unit quaternion (s, u), written without the zero scalar part: v + 2 u x (u x v - s v)
    turned = np.cross(q[..., 1:], rays)
    return np.asarray(rays + 2.0 * np.cross(q[..., 1:], turned - q[..., :1] * rays))


def ideal_image(exterior: Floats, cameras: Sequence[CameraModel], points: Floats) -> Floats:
    """(m, n, 2) ideal image coordinates in mm; NaN for a point that is not in front of the camera.

    cameras has one entry for each of the m images.
    """
    p = into_camera_frame(exterior, points)
    depth = np.where(p[..., 2] < 0.0, p[..., 2], np.nan)
    c = np.array([camera.c_mm for camera in cameras])[:, None, None]
    principal = np.array([(camera.x0_mm, camera.y0_mm) for camera in cameras])[:, None, :]
    return np.asarray(principal - c * p[..., :2] / depth[..., None])


def half_format(cameras: Sequence[CameraModel], margin_mm: float = 0.0) -> Floats:
    """(m, 2) mm: half of the film of m images with these cameras, less the margin."""
    return np.array([(camera.width_mm / 2.0, camera.height_mm / 2.0) for camera in cameras]) - margin_mm
