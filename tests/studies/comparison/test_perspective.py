"""The perspective reduction against a camera that is really turned."""

import numpy as np
import pytest

from studies.comparison.distortion_found import format_grid
from studies.comparison.perspective import perspective_reduction, tilt_terms

SMALL_RAD = 3e-7
"""so small that the second order, c a^2, is below 1e-9 mm"""
SECOND_ORDER_MM = 1e-9
C_MM = 153.0


def seen_by_turned_camera(xy, omega, phi):
    """Image points of the rays (x, y, -c) in a camera turned by small angles about x and about -y."""
    rays = np.column_stack([xy, np.full(len(xy), -C_MM)])
    turned = rays + np.cross([omega, -phi, 0.0], rays)
    return -C_MM * turned[:, :2] / turned[:, 2:]


@pytest.mark.parametrize(("omega", "phi"), [(SMALL_RAD, 0.0), (0.0, SMALL_RAD), (-2 * SMALL_RAD, SMALL_RAD)])
def test_terms_are_the_displacements_of_a_turned_camera(omega, phi):
    xy = format_grid()
    moved = seen_by_turned_camera(xy, omega, phi) - xy
    np.testing.assert_allclose(tilt_terms(xy, C_MM) @ [phi, omega], moved, atol=SECOND_ORDER_MM)


def test_a_tilt_is_taken_out_whole_and_its_angles_are_found():
    xy = format_grid()
    field = seen_by_turned_camera(xy, 3 * SMALL_RAD, -SMALL_RAD) - xy + [1e-4, -2e-4]
    found = perspective_reduction(xy, field, C_MM)
    np.testing.assert_allclose(found.field, 0.0, atol=SECOND_ORDER_MM)
    assert (found.omega, found.phi) == pytest.approx((3 * SMALL_RAD, -SMALL_RAD), rel=1e-4)
    np.testing.assert_allclose(found.shift, [1e-4, -2e-4], rtol=1e-4)


def test_what_is_no_tilt_stays():
    xy = format_grid()
    radial = 1e-9 * xy * np.sum(xy**2, axis=1)[:, None]
    np.testing.assert_allclose(perspective_reduction(xy, radial, C_MM).field, radial, atol=1e-12)


def test_reduced_field_does_not_depend_on_c_and_reduction_is_done_once():
    xy = format_grid()
    x, y = xy.T
    decentering = 3e-7 * np.column_stack([3 * x**2 + y**2, 2 * x * y])
    once = perspective_reduction(xy, decentering, C_MM)
    other = perspective_reduction(xy, decentering, 85.5)
    np.testing.assert_allclose(once.field, other.field, atol=1e-12)
    np.testing.assert_allclose(perspective_reduction(xy, once.field, C_MM).field, once.field, atol=1e-12)
    assert np.sum(once.field**2) < 0.1 * np.sum(decentering**2)
