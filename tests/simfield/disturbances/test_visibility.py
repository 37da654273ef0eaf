"""What is measured inside the format is shown, wherever an ideal camera would show it."""

import numpy as np
import pytest

from simfield.disturbances.distortion import DistortionError
from simfield.disturbances.effects import Decentering, EffectOn, FilmAffine, RadialPolynomial, RadialTable
from simfield.disturbances.visibility import shown
from simfield.world.cameras import CameraModel
from simfield.world.flights import Flight, plan_flights

CAMERA = CameraModel("slr", c_mm=20.0, width_mm=36.0, height_mm=24.0)
PLAN = plan_flights([Flight("a", "slr", 1e3)], [CAMERA])
HALF = np.tile([18.0, 12.0], (len(PLAN), 1))
ROUNDING_MM = 1e-12
"""A few units in the last place of 36 mm, through a solution by iteration."""


def grid(step_mm, reach=1.0):
    """Measured coordinates all over the format, and a rim outside it."""
    x, y = np.meshgrid(np.arange(-18.0 * reach, 18.0 * reach, step_mm), np.arange(-12.0 * reach, 12.0 * reach, step_mm))
    return np.column_stack([x.ravel(), y.ravel()])


def barrel(share):
    """Radial distortion of this share of the radius at 18 mm."""
    return RadialPolynomial(k1=share / 18.0**2, r0_mm=0.0)


@pytest.mark.parametrize(
    "effect",
    [
        barrel(-0.05),
        barrel(-0.1),
        barrel(-0.2),
        barrel(-0.4),
        barrel(0.1),
        Decentering(p1=1e-3, p2=-1e-3),
        FilmAffine(a=-0.3, d=0.2),
        RadialTable((10.0, 22.0), (-300.0, -2500.0)),
    ],
    ids=lambda e: e.kind,
)
def test_every_place_of_the_format_is_shown_and_none_outside(effect):
    measured = grid(0.7, 1.2) if not isinstance(effect, RadialTable) else grid(0.7, 0.999)
    measured = measured[np.hypot(*measured.T) < 22.0]
    ideal = measured - effect.displacement(measured)
    everywhere = np.tile(ideal, (len(PLAN), 1, 1))
    image, point, found = shown(everywhere, [EffectOn(effect)], PLAN, HALF)
    wanted = np.flatnonzero((np.abs(measured) <= [18.0, 12.0]).all(axis=1))
    for i in range(len(PLAN)):
        assert sorted(point[image == i]) == wanted.tolist()
    np.testing.assert_allclose(found, measured[point], rtol=0, atol=ROUNDING_MM)


def test_without_effects_the_format_decides_and_a_point_behind_the_camera_is_not_shown():
    ideal = np.array([[18.0, -12.0], [18.001, 0.0], [0.0, -12.001], [np.nan, np.nan], [3.0, 4.0]])
    _, point, found = shown(np.tile(ideal, (len(PLAN), 1, 1)), [], PLAN, HALF)
    assert point.tolist() == [0, 4] * len(PLAN)
    np.testing.assert_array_equal(found, ideal[point])


def test_an_effect_on_one_image_moves_the_edge_of_that_image_alone():
    ideal = np.array([[18.5, 0.0], [0.0, 0.0]])
    everywhere = np.tile(ideal, (len(PLAN), 1, 1))
    image, point, _ = shown(everywhere, [EffectOn(barrel(-0.1), image=PLAN.image_ids[1])], PLAN, HALF)
    assert image[point == 0].tolist() == [1]


def test_a_polynomial_that_runs_wild_outside_the_format_brings_nothing_in():
    # d = -0.02 r at 18 mm, and the seventh degree turns it round beyond
    effect = EffectOn(RadialPolynomial(k1=-1.5e-4, k3=2e-9, r0_mm=0.0))
    far = np.array([[60.0, 10.0], [200.0, 0.0], [25.0, 25.0]])
    _, point, _ = shown(np.tile(far, (len(PLAN), 1, 1)), [effect], PLAN, HALF)
    assert not len(point)


def test_a_table_that_ends_inside_the_format_is_refused_where_a_point_lies_beyond_it():
    table = [EffectOn(RadialTable((5.0, 10.0), (1.0, 2.0)))]
    near, far = np.array([[9.0, 0.0]]), np.array([[9.0, 0.0], [11.0, 0.0]])
    assert len(shown(np.tile(near, (len(PLAN), 1, 1)), table, PLAN, HALF)[1]) == len(PLAN)
    with pytest.raises(ValueError, match="beyond the distortion table"):
        shown(np.tile(far, (len(PLAN), 1, 1)), table, PLAN, HALF)


def test_a_distortion_that_folds_the_image_is_refused():
    with pytest.raises(DistortionError, match="folds the image"):
        shown(np.full((len(PLAN), 1, 2), 1.0), [EffectOn(FilmAffine(a=1.5))], PLAN, HALF)
