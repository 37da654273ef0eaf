"""The stages of the measurement chain that are random, and values that are refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from simfield import build_world, presets
from simfield.chain.comparator import Comparator, Errors, Marks
from simfield.chain.lens import RadialCertificate
from simfield.chain.measure import Chain, prepare
from simfield.chain.presets import STAGES, chains, without
from simfield.chain.random_field import RandomField, field_at
from simfield.disturbances.noise import Noise

QUIET = replace(presets["rheidt-1980"], effects=(), noise=Noise(image_um=0.0, assumed_um=5.0))
STANDARD_ERRORS = 4.0


@pytest.fixture(scope="module")
def world():
    return build_world(QUIET, 3)


def test_a_random_field_has_its_size_and_correlation():
    field = RandomField(3.0, 40.0)
    xy = np.array([[0.0, 0.0], [40.0, 0.0], [-70.0, 90.0], [0.0, 0.0]])
    at = field_at(field, xy, ("a", "a", "a", "b"), 125.0, 1)
    drawn = 1000.0 * np.stack([at.draw(trial) for trial in range(1500)]).transpose(1, 2, 0).reshape(4, -1)
    # two axes a trial
    n = drawn.shape[1]
    assert (np.abs(drawn.std(axis=1) - 3.0) < STANDARD_ERRORS * 3.0 / np.sqrt(2 * n)).all()
    r = np.corrcoef(drawn)
    assert abs(r[0, 1] - np.exp(-0.5)) < STANDARD_ERRORS / np.sqrt(n)
    assert abs(r[0, 3]) < STANDARD_ERRORS / np.sqrt(n)


def test_a_trial_is_measured_the_same_again(world):
    first, again = (prepare(world, chains["psk-1969"]).measure(4) for _ in range(2))
    np.testing.assert_array_equal(first.settings, again.settings)
    assert not np.array_equal(first.settings, prepare(world, chains["psk-1969"]).measure(5).settings)


def test_missed_points_are_left_out_and_gross_errors_have_their_share(world):
    raw = prepare(world, Chain(errors=Errors(missed_rate=0.1, gross_rate=0.05, gross_um=500.0))).measure(0)
    k = len(world.image)
    assert abs(len(raw.settings) - 0.9 * k) < STANDARD_ERRORS * np.sqrt(0.09 * k)
    ideal = {(i, p): xy for i, p, xy in zip(world.image, world.point, world.ideal.tolist(), strict=True)}
    o = raw.block.observations
    moved = [np.hypot(*(xy - ideal[i, p])) for i, p, xy in zip(o.image, o.point, o.xy, strict=True)]
    share = np.mean(np.array(moved) > 1e-6)
    assert abs(share - 0.05) < STANDARD_ERRORS * np.sqrt(0.05 * 0.95 / len(moved))


def test_confused_points_are_exchanged_in_pairs(world):
    raw = prepare(world, Chain(errors=Errors(confused_rate=0.2))).measure(0)
    o = raw.block.observations
    wrong = o.point != world.point
    assert 0 < wrong.sum() < len(wrong)
    for image in range(len(world.plan)):
        own = world.image == image
        assert sorted(o.point[own]) == sorted(world.point[own])


def test_settings_scatter_as_said(world):
    raw = prepare(world, Chain(comparator=Comparator(setting_um=2.0))).measure(0)
    difference = 1000.0 * (raw.settings[:, 1] - raw.settings[:, 0])
    expected = 2.0 * np.sqrt(2.0)
    assert abs(difference.std() - expected) < STANDARD_ERRORS * expected / np.sqrt(2 * difference.size)


def test_marks_lie_where_they_should():
    assert Marks("both").fiducial_positions().shape == (8, 2)
    crosses = Marks(reseau_spacing_mm=10.0).reseau_positions()
    assert crosses.shape == (441, 2)
    assert np.abs(crosses).max() == 100.0


def test_the_certificate_gives_back_its_half_diagonals():
    curves = ((0.0, 3.0, -2.0), (0.0, 1.0, 4.0), (0.0, -3.0, 0.5), (0.0, 2.0, 1.0))
    certificate = RadialCertificate((0.0, 80.0, 160.0), curves)
    for number, degrees in enumerate((45.0, 135.0, 225.0, 315.0)):
        ray = np.array([[np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))]])
        for radius, distortion in ((80.0, curves[number][1]), (160.0, curves[number][2])):
            d = certificate.displacement(radius * (1.0 - 1e-15) * ray)
            np.testing.assert_allclose(1000.0 * d, distortion * ray, rtol=0, atol=1e-9)
    assert certificate.mean.distortion_um == pytest.approx((0.0, 0.75, 0.875))


def test_what_makes_no_sense_is_refused():
    with pytest.raises(ValueError, match="four half-diagonals"):
        RadialCertificate((0.0, 80.0), ((0.0, 1.0),))
    with pytest.raises(ValueError, match="length_mm > 0"):
        RandomField(1.0, 0.0)
    with pytest.raises(ValueError, match="shares from 0"):
        Errors(gross_rate=1.0)


@pytest.mark.parametrize("stage", STAGES)
def test_a_stage_that_is_left_out_is_gone_and_the_others_stay(world, stage):
    chain = replace(chains["psk-1969"], errors=Errors(pointing_um=2.0))
    left = without(chain, stage)
    assert left != chain
    assert without(left, stage) == left
    for other in STAGES:
        # settings belong to the comparator, and stay when its own errors go
        assert without(without(chain, stage), other) == without(without(chain, other), stage)
    with_it, without_it = (prepare(world, c).measure(0) for c in (chain, left))
    same = [np.array_equal(getattr(with_it, name), getattr(without_it, name)) for name in ("settings", "mark_settings")]
    same += [np.array_equal(with_it.calibrated[c], without_it.calibrated[c]) for c in ("ww", "sww")]
    assert not all(same)


def test_without_every_stage_nothing_is_left():
    assert replace(without(chains["psk-1969"], *STAGES), name="undisturbed") == Chain()
    with pytest.raises(ValueError, match="no stage 'window'"):
        without(Chain(), "window")
