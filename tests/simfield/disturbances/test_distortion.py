"""measured = ideal + d(measured) is solved, not linearised."""

from dataclasses import dataclass

import numpy as np
import pytest

from simfield.disturbances.distortion import DistortionError, measured_from_ideal, systematic
from simfield.disturbances.effects import EffectOn, FilmAffine
from simfield.disturbances.film import FilmVariation, draw_film
from simfield.world.cameras import SWW, WW
from simfield.world.flights import Flight, plan_flights

EXACT_MM = 1e-13
"""A few units in the last place of 100 mm."""

PLAN = plan_flights([Flight("a", "ww", 1e4), Flight("b", "ww", 1e4), Flight("c", "sww", 1e4)], [WW, SWW])


@dataclass(frozen=True)
class Strong:
    """A test's own effect: an odd, steep function of x."""

    steepness: float

    def displacement(self, xy_mm):
        return np.column_stack([np.sin(self.steepness * xy_mm[:, 0]), 0.0 * xy_mm[:, 1]])


@pytest.mark.parametrize("steepness", [1e-4, 0.1, 0.8])
def test_the_solution_holds_to_rounding(steepness):
    ideal = np.random.default_rng(2).uniform(-115, 115, (500, 2))
    d = Strong(steepness).displacement
    measured = measured_from_ideal(ideal, d)
    np.testing.assert_allclose(measured, ideal + d(measured), rtol=0, atol=EXACT_MM)
    again = measured_from_ideal(ideal, d, start=measured + 0.01)
    np.testing.assert_allclose(again, measured, rtol=0, atol=10 * EXACT_MM)


def test_a_linear_effect_has_its_closed_solution():
    measured = measured_from_ideal(np.array([[50.0, 80.0]]), FilmAffine(a=0.01, d=-0.02).displacement)
    np.testing.assert_allclose(measured, [[50.0 / 0.99, 80.0 / 1.02]], rtol=0, atol=EXACT_MM)


@pytest.mark.parametrize("a", [1.5, -3.0, 1e300])
def test_what_cannot_be_solved_is_an_error(a):
    with pytest.raises(DistortionError, match="does not converge"):
        measured_from_ideal(np.array([[50.0, 80.0]]), FilmAffine(a=a).displacement)


def test_effects_of_camera_flight_and_image_add_up():
    effects = [
        EffectOn(FilmAffine(a=1.0)),
        EffectOn(FilmAffine(a=10.0), camera="ww"),
        EffectOn(FilmAffine(a=100.0), flight="b"),
        EffectOn(FilmAffine(a=1000.0), image="b-h0-2"),
    ]
    image = np.arange(len(PLAN))
    d = systematic(effects, PLAN, image)(np.ones((len(PLAN), 2)))
    assert d[:, 0].tolist() == [11, 11, 11, 111, 1111, 111, 1, 1, 1]


def test_film_of_single_images_as_array_and_as_effects_agree():
    film = draw_film([FilmVariation("ww", "affine", 8.0), FilmVariation("sww", "quadratic", 7.0)], PLAN, 5, 0)
    image = np.repeat(np.arange(len(PLAN)), 4)
    xy = np.random.default_rng(3).uniform(-115, 115, (len(image), 2))
    effects = film.effects(PLAN)
    assert len(effects) == len(PLAN)
    np.testing.assert_allclose(film.displacement(xy, image), systematic(effects, PLAN, image)(xy), atol=1e-16)


def test_bilinear_film_has_its_term_alone():
    film = draw_film([FilmVariation("ww", "bilinear", 5.0)], PLAN, 5, 0)
    own = np.array(PLAN.camera_ids) == "ww"
    assert (film.coefficients[own][:, :, 3] != 0.0).all()
    assert (film.coefficients[:, :, [0, 1, 2, 4]] == 0.0).all()
    assert (film.coefficients[~own] == 0.0).all()


def test_film_varies_as_said():
    plan = plan_flights([Flight("a", "ww", 1e4, images_per_strip=400, forward_overlap=0.9)], [WW])
    coefficients = draw_film([FilmVariation("ww", "affine", 8.0)], plan, 6, 0).coefficients[:, :, :2]
    found = 1000.0 * 100.0 * coefficients
    standard_error = 8.0 / np.sqrt(2 * found.size)
    assert abs(found.std() - 8.0) < 3.0 * standard_error
