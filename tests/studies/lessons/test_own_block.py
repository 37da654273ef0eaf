"""Lesson 6: what holds for expected accuracies whatever the numbers, and why some blocks have none."""

import numpy as np
import pytest

from studies.lessons import own_block
from studies.lessons.lesson import LessonError
from studies.lessons.own_block import expected

ROUNDING = 1.0 + 1e-9


@pytest.mark.parametrize(("scale", "overlap"), [(10000, 0.6), (16000, 0.8), (6000, 0.6)])
def test_more_control_makes_no_point_worse(scale, overlap):
    """The same flight with further coordinates held fixed: cofactors can only fall."""
    few, more = expected(scale, overlap, "four corners"), expected(scale, overlap, "corners and centre")
    most = expected(scale, overlap, "all around")
    assert (more.std_mm <= ROUNDING * few.std_mm).all()
    assert (most.std_mm <= ROUNDING * few.std_mm).all()
    assert most.rms_z_mm < few.rms_z_mm


def test_the_standard_deviations_follow_sigma(monkeypatch):
    once = expected(10000, 0.6, "all around")
    monkeypatch.setattr(own_block, "NOISE_UM", 3.0 * own_block.NOISE_UM)
    assert expected(10000, 0.6, "all around").std_mm == pytest.approx(3.0 * once.std_mm, rel=1e-6)


def test_the_rules_of_thumb():
    """1 : 10 000, 153 mm, 60 % of 230 mm: base 920 m, height 1530 m; 10 000 x 4 um are 40 mm."""
    found = expected(10000, 0.6, "four corners")
    assert (found.base_m, found.height_m) == pytest.approx((920.0, 1530.0))
    assert found.rule_xy_mm == pytest.approx(40.0)
    assert found.rule_z_mm == pytest.approx(np.sqrt(2.0) * 1530.0 / 920.0 * 40.0)


def test_what_the_lesson_says():
    sagging, held = expected(6000, 0.6, "four corners"), expected(6000, 0.6, "corners and centre")
    high = expected(10000, 0.6, "four corners")
    assert sagging.images > high.images
    assert sagging.rms_z_mm > 10.0 * high.rms_z_mm
    assert held.rms_z_mm < high.rms_z_mm
    around = [expected(scale, 0.6, "all around") for scale in (8000, 16000)]
    assert around[1].rms_z_mm / around[0].rms_z_mm == pytest.approx(2.0, rel=0.25)
    more = expected(10000, 0.8, "four corners")
    assert more.rule_z_mm > high.rule_z_mm
    assert more.rms_z_mm < high.rms_z_mm


def test_a_block_without_control_is_explained():
    with pytest.raises(LessonError, match="no control"):
        expected(10000, 0.6, "none")


def test_a_block_without_overlap_is_explained():
    with pytest.raises(LessonError, match="cannot be adjusted"):
        expected(10000, 0.3, "four corners")


def test_too_many_images_are_refused():
    with pytest.raises(LessonError, match="fly higher"):
        expected(2000, 0.8, "four corners")


def test_every_place_of_the_controls_has_an_answer_or_a_reason():
    refused = 0
    for scale in range(own_block.SCALES[0], own_block.SCALES[1] + 1, 2000):
        for overlap in (0.3, 0.45, 0.55, 0.7, 0.8):
            try:
                found = expected(scale, overlap, "corners and centre")
            except LessonError:
                refused += 1
                continue
            assert np.isfinite(found.free_mm).all()
            assert (found.free_mm > 0.0).all()
    # 30 % leaves gaps, whatever the scale; 45 % at some
    assert 6 <= refused <= 12
