"""The projection is written three times: by quaternions in the simulator, by matrices in the engine, by scalars here.

None knows another; where they agree, an error would have to be made three times.
"""

from __future__ import annotations

import numpy as np
import pytest

from adjust.model.collinearity import project
from adjust.model.rotation import rotation_matrices
from simfield.block.block import Floats
from simfield.world.cameras import CameraModel
from simfield.world.imaging import ideal_image
from tests import synthetic

AGREEMENT_MM = 1e-9
"""coordinates of 1e4 m and 100 mm are rounded to 1e-12 m and 1e-14 mm; the image adds no more than a factor of ten"""

CAMERA = synthetic.WW
MODEL = CameraModel("ww", CAMERA.c_mm, CAMERA.x0_mm, CAMERA.y0_mm, CAMERA.width_mm, CAMERA.height_mm)


def seen_from(exterior: Floats, rng: np.random.Generator, count: int) -> Floats:
    """Points in the field of view of one image, near and far."""
    x, y = rng.uniform(-110.0, 110.0, (2, count))
    direction = np.column_stack([x, y, np.full(count, -CAMERA.c_mm)]) / CAMERA.c_mm
    distance = 10.0 ** rng.uniform(1.0, 4.0, (count, 1))
    return np.asarray(exterior[:3] + (distance * direction) @ rotation_matrices(exterior[None, 3:])[0].T)


@pytest.mark.parametrize("seed", range(25))
def test_random_attitudes(seed: int) -> None:
    """Any attitude at all, eight images at a time."""
    rng = np.random.default_rng(seed)
    for _ in range(8):
        exterior = np.r_[rng.uniform(-5000.0, 5000.0, 3), rng.uniform(-np.pi, np.pi, 3)]
        points = seen_from(exterior, rng, 20)
        engine, depth = project(
            exterior[None], np.array([[CAMERA.c_mm, CAMERA.x0_mm, CAMERA.y0_mm]]), points, np.zeros(20, dtype=int)
        )
        simulator = ideal_image(exterior[None], [MODEL], points)[0]
        scalar = np.array([synthetic.project(CAMERA, exterior, point) for point in points])
        assert (depth > 0.0).all()
        np.testing.assert_allclose(engine, simulator, rtol=0.0, atol=AGREEMENT_MM)
        np.testing.assert_allclose(engine, scalar, rtol=0.0, atol=AGREEMENT_MM)


@pytest.mark.parametrize("kappa_deg", [-180.0, -90.0, 0.0, 90.0, 180.0, 359.999999])
@pytest.mark.parametrize("omega_deg", [0.0, 41.0, -89.0])
@pytest.mark.parametrize("phi_deg", [0.0, 89.0, 90.0, 120.0])
def test_particular_attitudes(omega_deg: float, phi_deg: float, kappa_deg: float) -> None:
    """Quarter turns, and phi of 90 degrees, where omega and kappa turn about the same axis."""
    exterior = np.r_[100.0, -200.0, 1600.0, np.deg2rad([omega_deg, phi_deg, kappa_deg])]
    points = seen_from(exterior, np.random.default_rng(1), 20)
    engine, _ = project(
        exterior[None], np.array([[CAMERA.c_mm, CAMERA.x0_mm, CAMERA.y0_mm]]), points, np.zeros(20, dtype=int)
    )
    np.testing.assert_allclose(engine, ideal_image(exterior[None], [MODEL], points)[0], rtol=0.0, atol=AGREEMENT_MM)


def test_they_agree_on_what_lies_behind() -> None:
    rng = np.random.default_rng(3)
    exterior = np.r_[0.0, 0.0, 1500.0, 0.3, -0.2, 2.0]
    points = exterior[:3] + rng.uniform(-3000.0, 3000.0, (200, 3))
    interior = np.array([[CAMERA.c_mm, CAMERA.x0_mm, CAMERA.y0_mm]])
    _, depth = project(exterior[None], interior, points, np.zeros(200, dtype=int))
    nowhere = np.isnan(ideal_image(exterior[None], [MODEL], points)[0]).all(axis=1)
    np.testing.assert_array_equal(depth <= 0.0, nowhere)
    assert nowhere.any()
    assert not nowhere.all()
