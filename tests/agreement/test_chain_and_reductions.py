"""The simulator's chain and the engine's reductions are written apart, and are inverse to each other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from adjust import reductions
from adjust.reductions.reduction import ReductionPlan, reduce
from simfield import build_world, presets
from simfield.chain.air import Air
from simfield.chain.comparator import Comparator, Marks
from simfield.chain.lens import Lens, RadialCertificate
from simfield.chain.measure import Chain, prepare
from simfield.chain.presets import chains
from simfield.disturbances.effects import Decentering
from simfield.disturbances.film import FilmVariation
from simfield.disturbances.noise import Noise

EXACT_MM = 1e-9
FORMULA_MM = 1.1e-3
"""what Bertram's formula leaves of traced refraction in the corners of the images of 1980; 0.5 um on their sides"""
RADII = (0.0, 30.0, 60.0, 90.0, 120.0, 165.0)
QUIET = replace(presets["rheidt-1980"], effects=(), noise=Noise(image_um=0.0, assumed_um=5.0))
NOTHING = ReductionPlan("helmert", drift=False, comparator=False, lens=False, refraction=False, curvature=False)
SMALL = st.floats(-1.0, 1.0)
FEW = settings(max_examples=8, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)


@pytest.fixture(scope="module")
def world():
    return build_world(QUIET, 11)


def largest_difference(world, chain, plan):
    reduced = reduce(prepare(world, chain).measure(0), plan)
    return np.abs(reduced.block.observations.xy - world.ideal).max()


def film_world(*terms, um=15.0, per="image"):
    film = tuple(FilmVariation(camera, t, um, per) for camera in ("ww", "sww") for t in terms)
    return build_world(replace(QUIET, film=film), 12)


def test_an_undisturbed_chain_is_nothing_but_a_change_of_frame(world):
    assert largest_difference(world, Chain(), NOTHING) < EXACT_MM


@FEW
@given(refraction=st.booleans(), curvature=st.booleans())
def test_air(world, refraction, curvature):
    plan = replace(NOTHING, refraction=refraction, curvature=curvature)
    found = largest_difference(world, Chain(air=Air(refraction, curvature)), plan)
    assert 0.5 * FORMULA_MM < found < FORMULA_MM if refraction else found < EXACT_MM


@FEW
@given(values=st.lists(SMALL, min_size=20, max_size=20))
def test_lens_by_its_certificate(world, values):
    curves = tuple((0.0, *(10.0 * v for v in values[5 * i : 5 * i + 5])) for i in range(4))
    chain = Chain(lenses=(Lens("ww", RadialCertificate(RADII, curves)), Lens("sww", RadialCertificate(RADII, curves))))
    assert largest_difference(world, chain, replace(NOTHING, lens=True)) < EXACT_MM


@FEW
@given(v=st.tuples(*[SMALL] * 7))
def test_decentering_tilt_and_interior_one_after_the_other(v):
    ideal = np.random.default_rng(0).uniform(-110, 110, (200, 2))
    lens = Lens("ww", None, Decentering(1e-6 * v[0], 1e-6 * v[1]), (0.1 * v[2], 0.1 * v[3]), (v[4], v[5]), v[6])
    back = reductions.displaced(lens.distort(ideal, 153.0), lens.principal_point_mm, lens.principal_distance_mm, 153.0)
    back = reductions.tilt(back.xy, *lens.tilt_deg, 153.0)
    back = reductions.decentering(back.xy, lens.decentering.p1, lens.decentering.p2)
    np.testing.assert_allclose(back.xy, ideal, rtol=0, atol=EXACT_MM)


@FEW
@given(v=st.tuples(*[SMALL] * 5), turn=st.floats(0.0, 30.0), shift=st.floats(0.0, 200.0))
def test_comparator(world, v, turn, shift):
    machine = Comparator((300 * v[0], 300 * v[1]), 300 * v[2], (9 * v[3], 9 * v[4]), turn, shift)
    plan = replace(NOTHING, drift=True, comparator=True)
    assert largest_difference(world, Chain(comparator=machine), plan) < EXACT_MM


@pytest.mark.parametrize("per", ["image", "flight", "camera"])
@pytest.mark.parametrize("inner", ["affine", "projective"])
def test_affine_film_by_the_fiducials(inner, per):
    chain = Chain(comparator=Comparator(placement_sigma_deg=3.0, placement_sigma_mm=10.0))
    assert largest_difference(film_world("affine", per=per), chain, replace(NOTHING, inner=inner)) < EXACT_MM


def test_bilinear_film_by_the_fiducials():
    chain = Chain(marks=Marks("both"), comparator=Comparator(placement_sigma_mm=10.0))
    assert largest_difference(film_world("bilinear"), chain, replace(NOTHING, inner="bilinear")) < EXACT_MM


@pytest.mark.parametrize("fiducials", ["mid-side", "corner"])
def test_film_of_third_degree_by_the_reseau(fiducials):
    chain = Chain(marks=Marks(fiducials, reseau_spacing_mm=25.0), comparator=Comparator(placement_sigma_deg=5.0))
    plan = replace(NOTHING, reseau_degree=3)
    assert largest_difference(film_world("affine", "quadratic", "cubic"), chain, plan) < EXACT_MM


@FEW
@given(v=st.tuples(*[SMALL] * 9))
def test_all_stages_together(v):
    curves = tuple((0.0, *(5.0 * x for x in v[i : i + 5])) for i in range(4))
    chain = Chain(
        air=Air(curvature=True),
        lenses=(Lens("ww", RadialCertificate(RADII, curves)),),
        marks=Marks("both", reseau_spacing_mm=25.0),
        comparator=Comparator((100 * v[0], 100 * v[1]), 50 * v[2], (3 * v[3], 3 * v[4]), 2.0, 20.0),
    )
    world = film_world("affine", "quadratic", "cubic", um=10.0 * abs(v[5]))
    assert largest_difference(world, chain, ReductionPlan("helmert", reseau_degree=3, refraction=False)) < EXACT_MM


def test_a_smooth_random_field_is_taken_out_by_the_reseau_but_for_a_rest(world):
    chain = replace(chains["undisturbed"], film_field=chains["psk-1969"].film_field)
    with_reseau = replace(chain, marks=Marks("both", reseau_spacing_mm=10.0, reseau_half_mm=110.0))
    rms = []
    for stage, plan in ((chain, NOTHING), (with_reseau, replace(NOTHING, reseau_degree=9))):
        reduced = reduce(prepare(world, stage).measure(0), replace(plan, inner="affine"))
        rms.append(np.sqrt(np.mean((reduced.block.observations.xy - world.ideal) ** 2)))
    assert rms[0] > 1.5e-3
    assert rms[1] < 0.3 * rms[0]


@pytest.mark.parametrize(("refraction", "left_mm"), [(False, EXACT_MM), (True, FORMULA_MM)])
def test_what_reductions_remove_is_what_the_stage_put_in(world, refraction, left_mm):
    chain = Chain(air=Air(refraction, True))
    reduced = reduce(prepare(world, chain).measure(0), replace(NOTHING, refraction=refraction, curvature=True))
    total = sum(reduced.removed[name] for name in ("refraction", "earth curvature") if name in reduced.removed)
    measured = prepare(world, chain).exposed[: len(world.ideal)]
    np.testing.assert_allclose(total, measured - world.ideal, rtol=0, atol=left_mm)
