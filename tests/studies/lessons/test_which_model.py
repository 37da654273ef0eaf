"""Lesson 3: the right set finds noise alone, and sigma0 does not tell how wrong a wrong one is."""

import numpy as np
import pytest

from adjust import ap_models
from simfield.disturbances.effects import EffectOn
from studies.lessons import which_model
from studies.lessons.adjusted import adjusted, observed, world_of

NOISE = 0.02
"""relative, of m0: 64 flights of a block with a redundancy of 48 and more"""
RIGHT = {
    "no distortion": which_model.SETS,
    "lens: radial and decentering": ("optical", "torlegard", "brown14"),
    "film: affinity": ("torlegard", "brown14", "ebner12"),
    "film: off its plane": ("brown14",),
}
"""sets whose terms contain the distortion, or what a block cannot tell from it, by the formulas of the paper"""


@pytest.fixture(scope="module")
def found():
    return {
        (truth, headings): which_model.compared(truth, which_model.SIZE_UM, headings)
        for truth in which_model.TRUTHS
        for headings in which_model.HEADINGS_GON
    }


@pytest.mark.parametrize("headings", which_model.HEADINGS_GON)
@pytest.mark.parametrize("truth", RIGHT)
def test_a_set_that_contains_the_distortion_leaves_noise_alone(found, truth, headings):
    for name, fitted in found[truth, headings].fitted.items():
        if name in RIGHT[truth]:
            assert fitted.m0_um == pytest.approx(which_model.NOISE_UM, rel=NOISE)
            assert fitted.residuals.rms_um < 0.02
        else:
            assert fitted.residuals.rms_um > 0.5


def test_the_distortion_has_the_size_that_is_said(found):
    for (truth, _), compared in found.items():
        wanted = 0.0 if truth == "no distortion" else which_model.SIZE_UM
        assert compared.true.rms_um == pytest.approx(wanted, abs=1e-9)


def test_lengths_are_not_scaled():
    radial, _ = which_model.scaled(which_model.TRUTHS["lens: radial and decentering"], 3.0)
    assert radial.r0_mm == 100.0


def test_residuals_are_those_of_the_images_in_each_cell():
    """A constant error of one cell comes out there, since a single cell has little say in the adjustment."""
    flown = which_model.scenario("no distortion", 0.0, 4)
    world = world_of(flown)
    block = observed(world)
    xy = world.distorted.copy()
    corner = (xy > which_model.HALF_FORMAT_MM * (1.0 - 2.0 / which_model.CELLS)).all(axis=1)
    xy[corner, 0] += 0.020
    field = which_model.mean_residuals(adjusted(block.replace_image_points(xy), ap_models.get("none")))
    largest = int(np.argmax(np.hypot(*field.vectors_um.T)))
    assert field.xy_mm[largest] == pytest.approx([which_model.HALF_FORMAT_MM * (1.0 - 1.0 / which_model.CELLS)] * 2)
    assert 5.0 < field.vectors_um[largest, 0] < 20.0


def test_the_effects_are_one_camera_s():
    flown = which_model.scenario("film: cubic", 8.0, 1)
    assert [type(on) for on in flown.effects] == [EffectOn]
    assert flown.effects[0].camera == "ww"


def test_what_the_lesson_says(found):
    lens = found["lens: radial and decentering", 4].fitted
    assert 1.02 < lens["ebner12"].m0_um / lens["optical"].m0_um < 1.03
    assert lens["ebner12"].rms_z_mm > 1.4 * lens["optical"].rms_z_mm
    unflat = found["film: off its plane", 4].fitted
    assert unflat["none"].m0_um > 1.4 * unflat["brown14"].m0_um
    assert unflat["none"].rms_xy_mm < 1.05 * unflat["brown14"].rms_xy_mm
    assert unflat["none"].rms_z_mm < 1.15 * unflat["brown14"].rms_z_mm
    for truth in which_model.TRUTHS:
        one, four = (found[truth, headings].fitted["none"].residuals.rms_um for headings in (1, 4))
        assert one <= 0.5 * four or four < 0.02
    idle = found["no distortion", 1].fitted
    assert idle["brown14"].rms_z_mm > 1.2 * idle["none"].rms_z_mm
    assert idle["brown14"].m0_um == pytest.approx(idle["none"].m0_um, rel=NOISE)
