"""Lesson 2: the paper's correlations, and that a second zero is a change of names."""

import numpy as np
import pytest

from studies.lessons import second_zero

SAME_BLOCK = 5e-4
"""relative difference of sigma0: tilts of a degree and the relief keep a change of scale from being one of height"""
SHIFT_MM = 5.0
"""of a point, for the same reason; their standard deviations are 20 to 60 mm"""


@pytest.fixture(scope="module", params=list(second_zero.CAMERAS))
def curve(request):
    return second_zero.curve(second_zero.flown(request.param, aux_points=False))


def at(curve, r0_mm):
    return next(c for c in curve if c.r0_mm == r0_mm)


def test_the_correlation_with_the_height_collapses(curve):
    """Mauelshagen 1980: 0.80 to 0.85 without r0, almost none with r0 = 100 mm."""
    assert 0.70 < at(curve, 0.0).z0_a3 < 0.90
    assert at(curve, 100.0).z0_a3 < 0.20


def test_the_correlation_of_the_terms_is_the_paper_s(curve):
    """Mauelshagen 1980: -0.92 without auxiliary points, whatever r0."""
    assert [c.a3_a4 for c in curve] == pytest.approx([-0.92] * len(curve), abs=0.01)


def test_a_second_zero_changes_names_and_nothing_else(curve):
    without, here = at(curve, 0.0), at(curve, 100.0)
    assert here.sigma0 == pytest.approx(without.sigma0, rel=SAME_BLOCK)
    assert second_zero.largest_shift_mm(without, here) < SHIFT_MM
    assert without.std_z0_mm > 1.5 * here.std_z0_mm
    r = second_zero.RADII_MM
    scale = (without.radial_um - here.radial_um)[1:] / r[1:]
    assert np.ptp(scale) < 0.1 * np.abs(scale.mean())


def test_the_curve_vanishes_at_its_second_zero(curve):
    here = at(curve, 100.0)
    place = int(np.flatnonzero(second_zero.RADII_MM == 100.0)[0])
    assert (here.radial_um[place], here.radial_std_um[place]) == pytest.approx((0.0, 0.0), abs=1e-9)
