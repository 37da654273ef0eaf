"""Lesson 5: a planted error does what Baarda's formulas say."""

import numpy as np
import pytest
from scipy.stats import norm

from studies.lessons import gross_error
from studies.lessons.gross_error import ACROSS, ALONG, AXES, NOISE_UM, RAYS, planted
from studies.lessons.lesson import LessonError

LINEAR = 0.01
"""relative: an error of 30 um is small against the curvature of the projection"""


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("place", RAYS)
def test_an_error_moves_w_and_is_estimated_as_theory_says(place, axis):
    clean, wrong = planted(place, axis, 0.0), planted(place, axis, 30.0)
    r, row = wrong.redundancy, wrong.row
    assert wrong.rays == RAYS[place]
    moved = wrong.w[row] - clean.w[row]
    assert abs(moved) == pytest.approx(30.0 * np.sqrt(r) / NOISE_UM, rel=LINEAR)
    assert wrong.estimated_um - clean.estimated_um == pytest.approx(30.0, rel=LINEAR)
    # 4.13: Baarda's delta0 for 0.1 % and 80 %
    assert wrong.mdb_um == pytest.approx(4.13 * NOISE_UM / np.sqrt(r), rel=1e-3)


def test_the_power_at_the_minimal_detectable_bias_is_the_asked_one():
    found = planted("seen in 6 images", ALONG, 0.0)
    assert found.power(found.mdb_um) == pytest.approx(gross_error.POWER, abs=1e-4)
    assert found.power(0.0) == pytest.approx(gross_error.ALPHA, rel=1e-6)
    shift = 10.0 * np.sqrt(found.redundancy) / NOISE_UM
    both_tails = norm.sf(3.2905 - shift) + norm.cdf(-3.2905 - shift)
    assert found.power(10.0) == pytest.approx(both_tails, abs=1e-4)


def test_what_the_lesson_says():
    large = gross_error.SIZE_MOST_UM
    assert planted("seen in 6 images", ALONG, large).found
    hidden = planted("seen in 2 images", ALONG, large)
    assert hidden.redundancy < 0.01
    assert not hidden.found
    assert abs(hidden.shift_mm[2]) > 3.0 * hidden.std_mm[2]
    assert not planted("seen in 3 images", ALONG, 40.0).found
    noticed = planted("seen in 2 images", ACROSS, large)
    of_point = noticed.name.partition(" of ")[2].partition(" in ")[0]
    assert noticed.name.startswith("y of point ")
    assert len([name for name in noticed.accused_names if f" of {of_point} in " in name]) == 1
    assert planted("seen in 6 images", ALONG, 0.0).accused


@pytest.mark.parametrize(("place", "axis", "size"), [("seen in 9 images", ALONG, 1.0), ("seen in 2 images", "z", 1.0)])
def test_a_coordinate_that_there_is_not_is_refused(place, axis, size):
    with pytest.raises(LessonError, match="no coordinate"):
        planted(place, axis, size)


@pytest.mark.parametrize("size", [101.0, float("nan"), -float("inf")])
def test_an_error_beyond_all_measure_is_refused(size):
    with pytest.raises(LessonError, match="at most 100"):
        planted("seen in 2 images", ALONG, size)
