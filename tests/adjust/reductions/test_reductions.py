"""Reductions of measured coordinates: sizes, residuals, redundancy, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import adjust_block, ap_models, reductions
from simfield import presets, simulate

WITHIN = 0.05
IN_LAST_DIGIT = 0.05
"""um: the tables have one decimal"""
FIDUCIALS = np.array([[113.0, 0.0], [0.0, 113.0], [-113.0, 0.0], [0.0, -113.0]])
CORNERS = np.array([[106.0, 106.0], [-106.0, 106.0], [-106.0, -106.0], [106.0, -106.0]])
RNG = np.random.default_rng(4)


@pytest.mark.parametrize(
    ("c_mm", "height_m", "refraction_um", "curvature_um"),
    [(153.0, 1606.5, (0.9, 2.4, 4.2), (0.7, 5.4, 14.9)), (85.2, 869.0, (0.6, 2.1, 4.7), (1.2, 9.4, 25.8))],
)
def test_air_has_the_tabulated_sizes(c_mm, height_m, refraction_um, curvature_um):
    xy = np.array([[50.0, 0.0], [0.0, 100.0], [-140.0, 0.0]])
    image, c = np.zeros(3, dtype=int), np.array([c_mm])
    camera, ground = np.array([height_m + 50.0]), np.array([50.0])
    bent = reductions.refraction(xy, image, c, camera, ground).removed
    curved = reductions.earth_curvature(xy, image, c, camera, ground).removed
    outward = np.sum(bent * xy, axis=1) / np.hypot(*xy.T)
    inward = -np.sum(curved * xy, axis=1) / np.hypot(*xy.T)
    np.testing.assert_allclose(1000.0 * outward, refraction_um, rtol=WITHIN, atol=IN_LAST_DIGIT)
    np.testing.assert_allclose(1000.0 * inward, curvature_um, rtol=WITHIN, atol=IN_LAST_DIGIT)


@pytest.mark.parametrize(("kind", "redundancy"), [("helmert", 4), ("affine", 2), ("bilinear", 0), ("projective", 0)])
def test_redundancy_of_four_fiducials(kind, redundancy):
    measured = FIDUCIALS if kind != "bilinear" else CORNERS  # four mid-sides all have x y = 0
    disturbed = measured + 0.01 * RNG.standard_normal((4, 2))
    found = reductions.inner_orientation(kind, disturbed, measured, np.zeros(4, dtype=int), 1)
    assert found.redundancy.tolist() == [redundancy]
    assert np.isnan(found.sigma0_um[0]) == (redundancy == 0)
    if redundancy == 0:
        np.testing.assert_allclose(found.residuals, 0.0, atol=1e-9)


@pytest.mark.parametrize("kind", ["helmert", "affine", "bilinear", "projective"])
def test_residuals_are_orthogonal_to_the_parameters(kind):
    marks = np.concatenate([FIDUCIALS, CORNERS])
    measured = marks + 0.01 * RNG.standard_normal((8, 2))
    image = np.zeros(8, dtype=int)
    found = reductions.inner_orientation(kind, measured, marks, image, 1)
    best = np.sum(found.residuals**2)
    for column in range(found.parameters.shape[1]):
        for step in (-1e-5, 1e-5):
            parameters = found.parameters.copy()
            parameters[0, column] += step
            moved = type(found)(kind, parameters, found.centre, found.residuals, found.redundancy, found.sigma0_um)
            assert np.sum((marks - moved.apply(measured, image).xy) ** 2) > best


def test_a_projective_transformation_is_recovered():
    marks = np.concatenate([FIDUCIALS, CORNERS])
    points = RNG.uniform(-110, 110, (20, 2))

    def machine(xy):
        below = 1.0 + 2e-6 * xy[:, 0] - 3e-6 * xy[:, 1]
        return (xy @ np.array([[0.9, 0.4], [-0.4, 0.9]]) + [30.0, -70.0]) / below[:, None]

    found = reductions.inner_orientation("projective", machine(marks), marks, np.zeros(8, dtype=int), 1)
    np.testing.assert_allclose(found.apply(machine(points), np.zeros(20, dtype=int)).xy, points, rtol=0, atol=1e-9)


def test_too_few_fiducials_are_refused():
    with pytest.raises(ValueError, match="affine needs 3 fiducials"):
        reductions.inner_orientation("affine", FIDUCIALS[:2], FIDUCIALS[:2], np.zeros(2, dtype=int), 1)
    with pytest.raises(ValueError, match="no inner orientation"):
        reductions.inner_orientation("spline", FIDUCIALS, FIDUCIALS, np.zeros(4, dtype=int), 1)


def test_double_measurement_finds_the_noise_and_the_blunder():
    place = RNG.uniform(-100, 100, (4000, 1, 2))
    settings = place + 0.002 * RNG.standard_normal((4000, 2, 2))
    settings[7, 1, 0] += 0.05
    found = reductions.double_measurement(settings)
    assert np.flatnonzero(found.doubtful).tolist() == [7]
    assert abs(found.sigma_um - 2.0) < 4.0 * 2.0 / np.sqrt(2 * 2 * 4000)
    with pytest.raises(ValueError, match="one or two settings"):
        reductions.double_measurement(np.zeros((3, 3, 2)))


def test_points_beyond_the_certificate_are_refused():
    with pytest.raises(ValueError, match="beyond the certificate"):
        reductions.radial(np.array([[120.0, 120.0]]), np.array([0.0, 165.0]), np.zeros((4, 2)))


def test_ap_sets_by_flight_strip_and_image():
    block, truth = simulate(presets["rheidt-1980-film"], seed=2)
    model = ap_models.get("torlegard")
    by_camera = adjust_block(block, model)
    same = adjust_block(block, model, ap_by=dict(zip(truth.image_ids, truth.camera_ids, strict=True)))
    assert list(same.ap) == ["sww", "ww"] or list(same.ap) == ["ww", "sww"]
    np.testing.assert_allclose(same.vpv, by_camera.vpv, rtol=1e-12)
    before = by_camera.vpv
    for owners, sets in ((truth.flight_ids, 4), (truth.strip_ids, 13), (truth.image_ids, 39)):
        ap_by = dict(zip(truth.image_ids, owners, strict=True))
        finer = adjust_block(block, model, ap_by=ap_by)
        assert finer.unknowns == by_camera.unknowns + 6 * (sets - 2)
        assert len(finer.ap) == sets
        assert finer.vpv < before
        plain = adjust_block(block, model, ap_by=ap_by, compiled=False)
        np.testing.assert_allclose(plain.vpv, finer.vpv, rtol=1e-10)
        before = finer.vpv


def test_a_set_of_two_cameras_is_refused():
    block, _ = simulate(presets["rheidt-1980"], seed=2)
    with pytest.raises(ValueError, match="images of the cameras"):
        adjust_block(block, ap_models.get("optical"), ap_by=dict.fromkeys(block.images.ids, "all"))
