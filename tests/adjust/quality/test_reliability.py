"""Reliability against the textbook's matrices, formed in full on small blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.stats

from adjust import Adjustment, adjust_block, ap_models
from adjust.quality.reliability import Reliability, familywise, noncentrality, tau_critical, w_critical
from simfield import presets, simulate
from simfield.block.block import Block, Floats
from tests import synthetic
from tests.adjust import dense

MODELS = ("none", "torlegard", "brown14")


@dataclass(frozen=True)
class Textbook:
    """R, v and weights of all observations in the order of the block, from one full design matrix."""

    r: Floats
    v: Floats
    weight: Floats
    q: Floats
    a: Floats

    @classmethod
    def of(cls, a: Adjustment) -> Textbook:
        design, v, weight = dense.in_block_order(a)
        hat, _ = dense.factors(np.sqrt(weight)[:, None] * design[:, a.layout.free])
        root = np.sqrt(weight)
        r = (np.eye(len(v)) - hat @ hat.T) * root / root[:, None]
        return cls(r, v, weight, dense.solve(a.groups, a.x).inverse, design)


def weighted_control(w: synthetic.World) -> synthetic.World:
    return w.controlled(synthetic.CONTROL, (0.02, 0.01, 0.03))


@pytest.fixture(scope="module", params=MODELS)
def adjusted(request: pytest.FixtureRequest, two_camera_world: synthetic.World) -> Adjustment:
    w = weighted_control(two_camera_world).with_noise(np.random.default_rng(5))
    sigma = w.block.observations.sigma * np.random.default_rng(6).uniform(0.8, 2.0, (len(w.block.observations), 2))
    order = np.random.default_rng(7).permutation(len(sigma))
    o = w.block.observations
    mixed = type(o)(o.image[order], o.point[order], o.xy[order], sigma[order])
    a = adjust_block(Block(w.block.cameras, w.block.images, w.block.points, mixed), ap_models.get(request.param))
    assert a.status.ok, a.message
    return a


@pytest.fixture(scope="module")
def textbook(adjusted: Adjustment) -> Textbook:
    return Textbook.of(adjusted)


@pytest.fixture(scope="module")
def found(adjusted: Adjustment) -> Reliability:
    return Reliability.of(adjusted)


def test_redundancy_numbers(adjusted: Adjustment, found: Reliability, textbook: Textbook) -> None:
    np.testing.assert_allclose(found.redundancy, np.diag(textbook.r), rtol=0.0, atol=dense.SAME)
    assert found.redundancy.sum() == pytest.approx(adjusted.redundancy, abs=len(found) * dense.SAME)
    assert found.redundancy.min() > 0.0


def test_standardised_residuals(adjusted: Adjustment, found: Reliability, textbook: Textbook) -> None:
    r, root = np.diag(textbook.r), np.sqrt(textbook.weight)
    w = root * textbook.v / np.sqrt(r)
    np.testing.assert_allclose(found.w, w, rtol=0.0, atol=dense.SAME)
    np.testing.assert_allclose(found.tau, w / adjusted.sigma0, rtol=0.0, atol=dense.SAME)
    np.testing.assert_allclose(found.estimated_error * root, -root * textbook.v / r, rtol=0.0, atol=dense.SAME)


def test_detectable_bias_and_its_effect(adjusted: Adjustment, found: Reliability, textbook: Textbook) -> None:
    delta0, r = noncentrality(), np.diag(textbook.r)
    mdb = delta0 / np.sqrt(textbook.weight * r)
    np.testing.assert_allclose(found.mdb, mdb, rtol=dense.SAME)
    camera, image = adjusted.layout.sets[0], adjusted.block.images.ids[3]
    names = [(image, "Z0"), ("16", "Z"), ("33b" if "33b" in adjusted.block.points.ids else "33", "X")]
    names += [(camera.id, n) for n in camera.model.parameters[:2]]
    at = np.array([adjusted.layout.index(*name) for name in names])
    rows = np.array([0, 1, 77, 300, len(r) - 1, len(r) - 2])
    expected = (textbook.q[at] @ (textbook.a[rows].T * textbook.weight[rows])).T * mdb[rows][:, None]
    std = np.sqrt(np.diag(textbook.q)[at])
    np.testing.assert_allclose(found.effect(rows, *names) / std, expected / std, rtol=0.0, atol=dense.SAME)
    assert (np.abs(expected / std) <= found.external[rows][:, None]).all()
    worst, row = found.worst_effect(at)
    every = (textbook.q[at] @ (textbook.a.T * textbook.weight)).T * mdb[:, None]
    np.testing.assert_allclose(worst / std, np.abs(every).max(axis=0) / std, rtol=0.0, atol=dense.SAME)
    np.testing.assert_array_equal(row, np.abs(every).argmax(axis=0))


def test_correlation_of_tests(found: Reliability, textbook: Textbook) -> None:
    s = np.sqrt(textbook.weight)
    standard = textbook.r * s[:, None] / s
    rows = np.arange(0, len(s), 17)
    root = np.sqrt(np.diag(standard)[rows])
    expected = standard[np.ix_(rows, rows)] / root / root[:, None]
    np.testing.assert_allclose(found.test_correlation(rows, rows), expected, rtol=0.0, atol=dense.SAME)
    np.testing.assert_allclose(found.influence.column(17), standard[:, 17], rtol=0.0, atol=dense.SAME)


def test_a_residual_is_minus_its_share_of_the_error(ww_world: synthetic.World) -> None:
    """A small error planted in one observation of an error-free block comes back as -r times itself, nonlinearly
    too.
    """
    o = ww_world.block.observations
    xy = o.xy.copy()
    xy[40, 1] += 1e-4
    a = adjust_block(ww_world.with_image_points(xy).block, ap_models.get("optical"))
    found = Reliability.of(a)
    assert a.residuals[40, 1] == pytest.approx(-1e-4 * found.redundancy[81], rel=1e-4)
    assert found.estimated_error[81] == pytest.approx(1e-4, rel=1e-4)
    assert found.name(81) == f"y of point {a.block.points.ids[o.point[40]]} in image {a.block.images.ids[o.image[40]]}"


def test_control_that_nothing_checks(ww_world: synthetic.World) -> None:
    """Seven weighted coordinates are the datum and no more: errors in them show nowhere."""
    w = ww_world.controlled(("11", "15", "55"), (0.02, 0.02, 0.02))
    sigma = w.block.points.sigma.copy()
    sigma[w.block.points.ids.index("15"), :2] = np.nan
    found = Reliability.of(adjust_block(w.with_points(sigma=sigma).with_noise(np.random.default_rng(1)).block))
    control = slice(found.image_points.stop, None)
    assert found.redundancy[control].tolist() == [0.0] * 7
    assert np.isnan(found.w[control]).all()
    assert np.isinf(found.mdb[control]).all()
    assert np.isinf(found.external[control]).all()
    assert found.name(len(found) - 1) == "Z of control point 55"
    assert np.isfinite(found.w[found.image_points]).all()


def test_critical_values() -> None:
    assert noncentrality() == pytest.approx(4.132, abs=5e-4), "Baarda's 4.13"
    assert noncentrality(0.05, 0.8) == pytest.approx(2.80, abs=5e-3)
    assert w_critical(0.001) == pytest.approx(3.29, abs=5e-3)
    t = scipy.stats.t.isf(0.025, 9)
    assert tau_critical(10, 0.05) == pytest.approx(np.sqrt(10) * t / np.sqrt(9 + t**2), rel=1e-12)
    assert tau_critical(10**7, 0.001) == pytest.approx(w_critical(0.001), abs=1e-5)
    assert tau_critical(1, 0.05) == 1.0
    assert 1.0 - (1.0 - familywise(0.05, 6626)) ** 6626 == pytest.approx(0.05, rel=1e-9)


def test_tau_is_the_distribution_of_an_internally_studentised_residual() -> None:
    """tau^2 / f is beta distributed with 1/2 and (f - 1)/2."""
    for f in (2, 5, 30):
        bound = tau_critical(f, 0.05)
        assert scipy.stats.beta.sf(bound**2 / f, 0.5, (f - 1) / 2) == pytest.approx(0.05, rel=1e-9)


def test_redundancy_numbers_of_6626_observations_sum_to_the_redundancy() -> None:
    block, _ = simulate(presets["rheidt-1980"], seed=1)
    a = adjust_block(block, ap_models.get("brown14"))
    found = Reliability.of(a)
    assert len(found) == 6626
    assert found.redundancy.sum() == pytest.approx(a.redundancy, abs=1e-7)
