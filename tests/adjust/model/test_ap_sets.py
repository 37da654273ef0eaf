"""Sets of additional parameters by camera, flight, strip or image."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from adjust import adjust_block, ap_models
from adjust.model.set_owners import CHOICES, ap_sets
from adjust.quality.significance import finer_sets
from simfield import presets, simulate
from simfield.block.block import Block, Images
from simfield.disturbances.effects import EffectOn, FilmAffine
from simfield.disturbances.noise import Noise
from tests import synthetic

MODEL = ap_models.get("torlegard")
EVEN = replace(presets["rheidt-1980"], noise=Noise(image_um=4.0))
"""both cameras of one noise, so that the test has its level"""
LEVEL = 0.05


@pytest.mark.parametrize("preset", ["rheidt-1980", "grid-small", "convergent"])
def test_flights_and_strips_are_read_from_ids_as_they_were_flown(preset):
    block, truth = simulate(presets[preset], seed=1)
    owners = (truth.camera_ids, truth.flight_ids, truth.strip_ids, truth.image_ids)
    for by, owner in zip(CHOICES, owners, strict=True):
        assert ap_sets(block, by) == dict(zip(truth.image_ids, owner, strict=True))


def test_a_choice_is_a_mapping():
    block, truth = simulate(EVEN, seed=2)
    named = adjust_block(block, MODEL, ap_by="flight")
    given = adjust_block(block, MODEL, ap_by=dict(zip(truth.image_ids, truth.flight_ids, strict=True)))
    assert list(named.ap) == list(given.ap) == ["sww-before", "ww-before", "sww-after", "ww-after"] or set(
        named.ap
    ) == set(given.ap)
    np.testing.assert_array_equal(named.x, given.x)
    np.testing.assert_array_equal(adjust_block(block, MODEL, ap_by="camera").x, adjust_block(block, MODEL).x)


def test_ids_that_name_no_flight_are_refused():
    block, _ = simulate(EVEN, seed=2)
    images = Images(tuple(f"{i}" for i in range(len(block.images))), block.images.camera, block.images.exterior)
    plain = Block(block.cameras, images, block.points, block.observations)
    for by in ("flight", "strip"):
        with pytest.raises(ValueError, match=f"names no {by}"):
            adjust_block(plain, MODEL, ap_by=by)
    assert len(adjust_block(plain, MODEL, ap_by="image").ap) == len(images)
    with pytest.raises(ValueError, match="no AP sets by 'day'"):
        ap_sets(block, "day")


def test_the_f_test_is_that_of_its_formula():
    block, _ = simulate(EVEN, seed=2)
    coarse, fine = adjust_block(block, MODEL), adjust_block(block, MODEL, ap_by="flight")
    test = finer_sets(coarse, fine)
    statistic = (coarse.vpv - fine.vpv) / 12 / fine.sigma0**2
    assert (test.k, test.f) == (12, fine.redundancy)
    assert test.statistic == pytest.approx(statistic, rel=1e-12)
    assert test.p == pytest.approx(stats.f.sf(statistic, 12, fine.redundancy), rel=1e-9)
    with pytest.raises(ValueError, match="more unknowns"):
        finer_sets(fine, coarse)


def test_film_of_one_flight_is_significant_and_no_film_is_not():
    film = EffectOn(FilmAffine(d=1e-4), flight="ww-after")
    moved, _ = simulate(replace(EVEN, effects=(*EVEN.effects, film)), seed=3)
    assert finer_sets(adjust_block(moved, MODEL), adjust_block(moved, MODEL, ap_by="flight")).p < 1e-6
    still = [simulate(EVEN, seed=3, trial=t)[0] for t in range(12)]
    false = sum(finer_sets(adjust_block(b, MODEL), adjust_block(b, MODEL, ap_by="flight")).p < LEVEL for b in still)
    # four of twelve at 5 % come once in 450 times
    assert false < 4


@pytest.mark.parametrize(
    ("ap_by", "owner"), [("camera", "camera ww"), ("image", "image {image}"), ("own", "the set mine")]
)
def test_an_unknown_says_whose_set_it_is_of(ww_world: synthetic.World, ap_by: str, owner: str) -> None:
    block = ww_world.controlled(synthetic.CONTROL).block
    by = dict.fromkeys(block.images.ids, "mine") if ap_by == "own" else ap_by
    a = adjust_block(block, ap_models.get("optical"), ap_by=by)
    name = a.layout.name(6 * len(block.images))
    assert name == f"a3 of {owner.format(image=block.images.ids[0])}"
