"""The projection against rotation matrices typed from the convention, and what counts as visible."""

import numpy as np

from simfield.world.cameras import SWW, WW, CameraModel
from simfield.world.imaging import attitude_quaternion, half_format, ideal_image, into_camera_frame

ROUNDING_MM = 1e-9
"""Two formulas in double precision, with 1e3 m in the numbers and image coordinates up to metres."""


def rotation(omega, phi, kappa):
    """R1(omega) R2(phi) R3(kappa)."""
    so, co, sp, cp, sk, ck = (f(a) for a in (omega, phi, kappa) for f in (np.sin, np.cos))
    r1 = np.array([[1, 0, 0], [0, co, -so], [0, so, co]])
    r2 = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    r3 = np.array([[ck, -sk, 0], [sk, ck, 0], [0, 0, 1]])
    return r1 @ r2 @ r3


def test_projection_agrees_with_rotation_matrices_at_random_attitudes():
    random = np.random.default_rng(1)
    camera = CameraModel("c", c_mm=120.0, x0_mm=0.3, y0_mm=-0.2)
    exterior = np.column_stack([random.normal(0, 500, (200, 3)), random.uniform(-np.pi, np.pi, (200, 3))])
    points = random.normal(0, 800, (30, 3))
    images = ideal_image(exterior, [camera] * 200, points)
    seen = 0
    for row, found in zip(exterior, images, strict=True):
        p = (points - row[:3]) @ rotation(*row[3:])
        wanted = np.array([0.3, -0.2]) - 120.0 * p[:, :2] / p[:, 2:]
        assert np.isnan(found[p[:, 2] >= 0.0]).all(), "a point behind the camera has no image"
        near = (p[:, 2] < 0.0) & (np.abs(wanted) < 1000.0).all(axis=1)
        np.testing.assert_allclose(found[near], wanted[near], rtol=0, atol=ROUNDING_MM)
        seen += near.sum()
    assert seen > 1000


def test_a_vertical_image_with_the_numbers_of_a_hand_calculation():
    # 1000 m above the point, 100 m to its west and 50 m to its north; kappa 0: x east, y north.
    image = ideal_image(np.array([[0.0, 0.0, 1000.0, 0.0, 0.0, 0.0]]), [WW], np.array([[100.0, -50.0, 0.0]]))
    np.testing.assert_allclose(image[0, 0], [15.3, -7.65], rtol=0, atol=ROUNDING_MM)


def test_quaternions_keep_lengths():
    q = attitude_quaternion(np.array([[0.1, -0.7, 3.0]]))
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1.0, rtol=1e-15)
    rays = into_camera_frame(np.array([[1.0, 2.0, 3.0, 0.1, -0.7, 3.0]]), np.array([[4.0, 6.0, 15.0]]))
    np.testing.assert_allclose(np.linalg.norm(rays), 13.0, rtol=1e-15)


def test_half_of_the_film_less_the_margin():
    slr = CameraModel("slr", c_mm=20.0, width_mm=36.0, height_mm=24.0)
    assert half_format([SWW, slr], margin_mm=5.0).tolist() == [[110.0, 110.0], [13.0, 7.0]]
