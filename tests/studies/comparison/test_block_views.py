"""What figures show of a block: footprints held against the simulator's projection, ellipses against covariances."""

import numpy as np
import pytest

from adjust import adjust_block, ap_models
from simfield import presets, simulate
from simfield.block.block import Block, Camera, ImageObservations, Images, Points
from simfield.world.imaging import ideal_image
from studies.comparison.block_views import ap_exterior_correlations, footprints, mean_residuals, point_errors

GROUND_M = 50.0
CORNER_MM = 1e-9
"""agreement of two projections written apart"""
ROUNDING = 1e-12


def looking(exterior):
    """A block of one image over three points; only its orientation matters here."""
    camera = Camera("ww", 153.0, 0.02, -0.03, 230.0, 200.0)
    coordinates = np.array([[0.0, 0.0, 49.0], [100.0, 0.0, 50.0], [0.0, 100.0, 51.0]])
    points = Points(("a", "b", "c"), np.array(["control"] * 3), coordinates, np.zeros((3, 3)))
    seen = ImageObservations(np.zeros(3, int), np.arange(3), np.zeros((3, 2)), np.full((3, 2), 0.005))
    return Block((camera,), Images(("i",), np.zeros(1, int), np.array([exterior])), points, seen), camera


@pytest.fixture(scope="module")
def adjusted():
    block, truth = simulate(presets["grid-small"], 7)
    return adjust_block(block, ap_models.get("optical")), truth


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.1, -0.2, 2.5)])
def test_the_corners_of_a_footprint_are_seen_in_the_corners_of_the_image(angles):
    block, camera = looking([20.0, 30.0, 1580.0, *angles])
    corners = footprints(block, GROUND_M)[0]
    ground = np.column_stack([corners, np.full(4, GROUND_M)])
    xy = ideal_image(block.images.exterior, [camera], ground)[0]
    np.testing.assert_allclose(xy, [[-115, -100], [115, -100], [115, 100], [-115, 100]], atol=CORNER_MM)


def test_the_ground_is_the_mean_height_if_none_is_named():
    block, _ = looking([20.0, 30.0, 1580.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(footprints(block), footprints(block, GROUND_M))


def test_an_image_that_looks_up_has_no_footprint():
    block, _ = looking([20.0, 30.0, 1580.0, np.pi, 0.0, 0.0])
    assert np.isnan(footprints(block, GROUND_M)).all()


def test_ellipses_are_the_covariances_turned_to_their_axes(adjusted):
    a, _ = adjusted
    rows = np.flatnonzero(np.asarray(a.block.points.role) != "control")[:4]
    found = point_errors(a, rows)
    for place, row in enumerate(rows):
        name = a.points.ids[row]
        covariance = a.covariance((name, "X"), (name, "Y"))
        major, minor = found.semi_m[place]
        along = np.array([np.cos(found.angle[place]), np.sin(found.angle[place])])
        assert major >= minor > 0.0
        assert along @ covariance @ along == pytest.approx(major**2)
        assert np.linalg.det(covariance) == pytest.approx((major * minor) ** 2)
        assert found.height_m[place] == pytest.approx(a.points.std[row, 2])
    np.testing.assert_array_equal(found.xy_m, a.points.values[rows, :2])


def test_mean_residuals_are_those_of_their_cell(adjusted):
    a, _ = adjusted
    field = mean_residuals(a, "ww", cell_mm=50.0, least=2)
    xy = a.block.observations.xy
    assert len(field.xy_mm) > 4
    for centre, vector in zip(field.xy_mm, field.vectors_um, strict=True):
        own = np.all((xy >= centre - 25.0) & (xy < centre + 25.0), axis=1)
        assert own.sum() >= 2
        np.testing.assert_allclose(vector, 1000.0 * a.residuals[own].mean(axis=0), atol=ROUNDING)


def test_correlations_with_the_exterior_are_those_of_the_adjustment(adjusted):
    a, _ = adjusted
    image = a.images.ids[1]
    r = ap_exterior_correlations(a, "ww", image)
    assert r.shape == (4, 6)
    assert r[0, 2] == pytest.approx(a.correlation(("ww", "a3"), (image, "Z0"))[0, 1])
