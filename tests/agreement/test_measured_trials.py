"""Many trials through chain and reductions in compiled loops are the trials of the readable chain, and of any block."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from adjust import adjust_replicates, ap_models
from adjust.reductions.inner_compiled import KINDS
from adjust.reductions.reduction import ReductionPlan, reduce
from simfield import build_world, presets
from simfield.chain.air import Air
from simfield.chain.comparator import Comparator, Errors, Marks
from simfield.chain.lens import Lens
from simfield.chain.measure import Chain, prepare
from simfield.chain.presets import chains
from simfield.chain.random_field import RandomField
from simfield.disturbances.distortion import DistortionError
from simfield.disturbances.effects import Decentering, EffectOn, FilmAffine, FilmPolynomial, UnflatFilm
from simfield.disturbances.film import FilmVariation
from studies.trials.measured_trials import MeasuredTrials

AGREES_MM = 1e-9
FIRST = 21
FEW = settings(max_examples=6, deadline=None, suppress_health_check=list(HealthCheck), derandomize=True)
SHARE = st.floats(0.0, 1.0)
PSK = chains["psk-1969"]
NOTHING = ReductionPlan("helmert", drift=False, comparator=False, lens=False, refraction=False, curvature=False)
EVERYTHING = replace(PSK, marks=Marks("both", calibration_um=1.0), errors=Errors(2.0, 0.01, 120.0, 0.02))
EFFECTS = (
    EffectOn(FilmAffine(2e-5, -1e-5, 3e-5, 8e-5), camera="ww"),
    EffectOn(FilmPolynomial(dx_x2=5e-7, dy_xy2=8e-9), camera="sww"),
    EffectOn(UnflatFilm(b5=4e-7, b7=3e-9), camera="sww"),
)
STAGES = {
    "noise": (Chain(), NOTHING),
    "air": (Chain(air=Air(True, True, 20.0)), replace(NOTHING, refraction=True, curvature=True)),
    "lens": (Chain(lenses=PSK.lenses), replace(NOTHING, lens=True)),
    "lens, as it is": (Chain(lenses=(Lens("ww", decentering=Decentering(1e-7), tilt_deg=(0.1, 0.2)),)), NOTHING),
    "smooth field of images": (Chain(film_field=RandomField(4.0, 40.0)), NOTHING),
    "smooth field of flights": (Chain(film_field=RandomField(4.0, 60.0, "flight")), NOTHING),
    "marks": (Chain(marks=Marks("both", calibration_um=3.0), errors=Errors(3.0)), replace(NOTHING, inner="bilinear")),
    "machine": (
        Chain(comparator=replace(PSK.comparator, setting_um=0.0)),
        replace(NOTHING, drift=True, comparator=True),
    ),
    "two settings": (Chain(comparator=Comparator(setting_um=3.0)), NOTHING),
    "one setting": (Chain(comparator=Comparator(setting_um=3.0, settings=1)), NOTHING),
    "gross errors": (Chain(errors=Errors(gross_rate=0.05, gross_um=3000.0)), replace(NOTHING, refraction=True)),
    "taken for others": (Chain(errors=Errors(confused_rate=0.05)), replace(NOTHING, curvature=True)),
}


@pytest.fixture(scope="module")
def world():
    return build_world(replace(presets["rheidt-1980-film"], effects=EFFECTS), 11)


def one_by_one(prepared, plan, trials):
    """(t, k, 2) by the readable route, in the order of the world's observations."""
    found = []
    for trial in trials:
        raw = prepared.measure(trial)
        if plan is None:
            found.append(raw.settings.mean(axis=1))
            continue
        o = reduce(raw, plan).block.observations
        at = {(i, p): xy for i, p, xy in zip(o.image.tolist(), o.point.tolist(), o.xy, strict=True)}
        world = prepared.world
        found.append([at[i, p] for i, p in zip(world.image.tolist(), world.point.tolist(), strict=True)])
    return np.array(found)


def assert_same_as_one_by_one(world, chain, plan, count=2):
    prepared = prepare(world, chain)
    fast = MeasuredTrials(prepared, plan, FIRST, FIRST + count)[:]
    slow = one_by_one(prepared, plan, range(FIRST, FIRST + count))
    np.testing.assert_allclose(fast, slow, rtol=0, atol=AGREES_MM)


@pytest.mark.parametrize("name", STAGES)
def test_every_stage_alone(world, name):
    assert_same_as_one_by_one(world, *STAGES[name])


@pytest.mark.parametrize("inner", KINDS)
def test_all_stages_together(world, inner):
    assert_same_as_one_by_one(world, EVERYTHING, ReductionPlan(inner))


@pytest.mark.parametrize("degree", [1, 3, 5])
def test_reseau(world, degree):
    chain = replace(PSK, marks=Marks("corner", reseau_spacing_mm=25.0, calibration_um=1.0))
    assert_same_as_one_by_one(world, chain, ReductionPlan("affine", reseau_degree=degree), 1)


def test_machine_coordinates_as_they_are(world):
    assert_same_as_one_by_one(world, replace(EVERYTHING, errors=Errors(2.0)), None)


@FEW
@given(v=st.tuples(*[SHARE] * 9), inner=st.sampled_from(KINDS), per=st.sampled_from(["image", "flight", "camera"]))
def test_random_settings(v, inner, per):
    film = tuple(FilmVariation(c, t, 20.0 * v[0], per) for c in ("ww", "sww") for t in ("affine", "quadratic", "cubic"))
    world = build_world(replace(presets["rheidt-1980"], film=film), 12)
    chain = Chain(
        air=Air(v[1] > 0.5, v[2] > 0.5, 30.0 * v[1]),
        lenses=PSK.lenses if v[3] > 0.5 else (),
        film_field=RandomField(5.0 * v[4], 25.0 + 60.0 * v[5], per),
        marks=Marks("both", calibration_um=5.0 * v[5]),
        comparator=Comparator(
            (200 * v[6], -90 * v[7]), 80 * v[8], (4 * v[6], -3 * v[7]), 30 * v[8], 90 * v[6], 5 * v[7]
        ),
        errors=Errors(5.0 * v[8], 0.02 * v[6], 400.0 * v[7], 0.02 * v[8]),
    )
    assert_same_as_one_by_one(world, chain, ReductionPlan(inner, lens=v[3] > 0.2), 1)


def test_a_trial_has_the_same_bits_in_any_block(world):
    trials = MeasuredTrials(prepare(world, EVERYTHING), ReductionPlan("projective"), 0, 80)
    whole = trials[:]
    assert np.array_equal(trials[3:4], whole[3:4])
    assert np.array_equal(trials[30:49], whole[30:49])
    assert np.array_equal(replace(trials, start=17)[0:20], whole[17:37])
    assert np.array_equal(pickle.loads(pickle.dumps(trials))[8:9], whole[8:9])
    assert not np.array_equal(whole[0], whole[1])


@pytest.mark.parametrize("chain", [EVERYTHING, replace(EVERYTHING, errors=Errors(2.0))])
def test_some_observations_alone(world, chain):
    trials = MeasuredTrials(prepare(world, chain), ReductionPlan("affine"), 0, 20)
    rows = np.array([700, 5, 41, 3300, 40])
    assert np.array_equal(trials.only(rows)[1:19], trials[1:19][:, rows])
    assert np.array_equal(trials.only(rows).only(np.array([2, 0]))[1:3], trials[1:3][:, rows[[2, 0]]])


def test_replicates_take_them_as_they_are(world):
    prepared = prepare(world, PSK)
    trials = MeasuredTrials(prepared, ReductionPlan("affine"), 0, 40)
    block = reduce(prepared.measure(0), ReductionPlan("affine")).block
    drawn = adjust_replicates(block, ap_models.get("torlegard"), trials)
    given = adjust_replicates(block, ap_models.get("torlegard"), trials[:])
    np.testing.assert_array_equal(drawn.trials.x, given.trials.x)
    assert drawn.ok.all()
    two = adjust_replicates(block, ap_models.get("torlegard"), trials, jobs=2)
    np.testing.assert_array_equal(drawn.trials.x, two.trials.x)


def test_what_cannot_be_measured_together(world):
    with pytest.raises(ValueError, match="a geometry of its own"):
        MeasuredTrials(prepare(world, Chain(errors=Errors(missed_rate=0.1))), NOTHING, 0, 1)
    crosses = Chain(marks=Marks("both", reseau_spacing_mm=10.0))
    with pytest.raises(ValueError, match="at most 5"):
        _ = MeasuredTrials(prepare(world, crosses), replace(NOTHING, reseau_degree=7), 0, 1)[:]
    with pytest.raises(ValueError, match="step of 2"):
        _ = MeasuredTrials(prepare(world, Chain()), NOTHING, 0, 4)[0:4:2]
    with pytest.raises(ValueError, match="numbered from 0"):
        MeasuredTrials(prepare(world, Chain()), NOTHING, -1, 4)
    wild = build_world(replace(presets["rheidt-1980"], film=(FilmVariation("ww", "cubic", 900.0),)), 1)
    with pytest.raises(DistortionError, match="too much for many trials"):
        _ = MeasuredTrials(prepare(wild, Chain()), NOTHING, 0, 1)[:]
