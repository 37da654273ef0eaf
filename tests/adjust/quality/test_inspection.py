"""The order of the tests: who is less precise than stated is not accused; who is wrong is, as often as is stated."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import nct

from adjust import Adjustment, InnerConstraints, adjust_block, ap_models
from adjust.quality import familywise, inspected, snoop, tau_noncentrality
from adjust.quality.influence import Influence
from adjust.quality.inspection import OF_ITS_OWN_LEAST
from adjust.quality.level_of_all import _residuals, level_of_one
from adjust.quality.reliability import tau_critical
from tests import synthetic
from tests.adjust.quality.test_reliability import Textbook

FACTORS = {"ww": 0.6, "sww": 1.6}
ERRORS_MOST = 3.0
"""in binomial standard errors"""
BLOCKS = 100


def unequal(w: synthetic.World, random: np.random.Generator) -> np.ndarray:
    """Image coordinates with other noise than is stated, another one for each camera."""
    o, b = w.block.observations, w.block
    factor = np.array([FACTORS[b.cameras[c].camera_id] for c in b.images.camera[o.image]])
    return o.xy + factor[:, None] * o.sigma * random.standard_normal(o.xy.shape)


@pytest.fixture(scope="module")
def adjusted(two_camera_world: synthetic.World) -> Adjustment:
    xy = unequal(two_camera_world, np.random.default_rng(4))
    return adjust_block(two_camera_world.with_image_points(xy).block, ap_models.get("optical"))


def test_simulated_residuals_are_those_of_the_textbook(adjusted: Adjustment) -> None:
    book = Textbook.of(adjusted)
    root = np.sqrt(book.weight)
    r = book.r * root[:, None] / root
    found = _residuals(Influence.of(adjusted), np.random.default_rng([1968, 3]))
    errors = np.random.default_rng([1968, 3]).standard_normal(found.shape)
    np.testing.assert_allclose(found, errors @ r.T, atol=1e-9)


def test_the_level_is_that_of_independent_tests_where_they_are(adjusted: Adjustment) -> None:
    """Tests of points seen in many images nearly are; the number of vectors leaves a share of 3 %."""
    influence = Influence.of(adjusted)
    label = np.full(len(influence), -1)
    one = np.zeros(len(influence), dtype=bool)
    one[10] = True
    assert level_of_one(influence, label, 0.05, one) == pytest.approx(0.05, rel=0.1)
    everything = np.ones(len(influence), dtype=bool)
    found = level_of_one(influence, label, 0.05, everything)
    assert 0.9 < found / familywise(0.05, len(influence)) < 3.0


def test_the_shift_of_the_tau_test() -> None:
    """Beside scipy's noncentral t, for the statistic as it is."""
    for f, alpha in ((12.0, 0.01), (200.0, 1e-4)):
        t = tau_critical(f, alpha)
        t = t * np.sqrt((f - 1.0) / (f - t**2))
        assert nct.sf(t, f - 1.0, tau_noncentrality(f, alpha, 0.8)) == pytest.approx(0.8, abs=1e-6)


def test_groups_get_their_own_sigma0(adjusted: Adjustment) -> None:
    found = inspected(adjusted)
    assert found.components is not None
    assert dict(zip(found.components.names, found.components.sigma_factor, strict=True)) == pytest.approx(
        {"images of ww": 0.6, "images of sww": 1.6}, rel=0.1
    )
    assert found.adjustment.sigma0 == pytest.approx(1.0, abs=0.01)


def test_small_groups_keep_what_is_stated(two_camera_world: synthetic.World) -> None:
    """An error of one control coordinate of fifteen would hide in a component of their own."""
    w = two_camera_world.controlled(synthetic.CONTROL, (0.02, 0.02, 0.03)).with_noise(np.random.default_rng(3))
    coordinates = w.block.points.coordinates.copy()
    at = w.block.points.ids.index("11")
    coordinates[at, 2] += 1.0
    a = adjust_block(w.with_points(coordinates=coordinates).block)
    found = inspected(a)
    assert found.components is not None
    assert "control" not in found.components.names
    assert OF_ITS_OWN_LEAST > 15
    assert [each.name for each in found.snooping.accused] == ["Z of control point 11"]


def test_what_is_accused_does_not_raise_its_component(two_camera_world: synthetic.World) -> None:
    w = two_camera_world
    xy = unequal(w, np.random.default_rng(4))
    wrong = {(5, 0): 60.0, (40, 1): -50.0, (90, 0): 40.0, (130, 1): 70.0}
    for (k, axis), size in wrong.items():
        xy[k, axis] += size * synthetic.SIGMA_MM
    found = inspected(adjust_block(w.with_image_points(xy).block, ap_models.get("optical")))
    assert set(found.suspected) == {2 * k + axis for k, axis in wrong}
    assert found.components is not None
    assert dict(zip(found.components.names, found.components.sigma_factor, strict=True)) == pytest.approx(
        {"images of ww": 0.6, "images of sww": 1.6}, rel=0.1
    )


def test_a_free_network_is_inspected_as_one(two_camera_world: synthetic.World) -> None:
    w = two_camera_world.with_noise(np.random.default_rng(3))
    a = adjust_block(w.block, datum=InnerConstraints())
    assert type(inspected(a).adjustment) is type(a)


@pytest.mark.slow
def test_clean_blocks_are_accused_in_the_stated_share(two_camera_world: synthetic.World) -> None:
    """With two cameras of unequal precision, both stated wrongly; one sigma0 for both accuses in most of them."""
    random, alpha, hits, before = np.random.default_rng(11), None, 0, 0
    for _ in range(BLOCKS):
        a = adjust_block(
            two_camera_world.with_image_points(unequal(two_camera_world, random)).block, ap_models.get("none")
        )
        found = inspected(a, alpha=alpha)
        alpha = found.alpha
        hits += bool(len(found.suspected))
        before += bool(snoop(a, familywise(0.05, a.observations), "tau").accused)
    assert abs(hits / BLOCKS - 0.05) < ERRORS_MOST * np.sqrt(0.05 * 0.95 / BLOCKS)
    assert before > 2 * hits


@pytest.mark.slow
def test_the_power_at_the_printed_bias(two_camera_world: synthetic.World) -> None:
    """One coordinate a block is wrong by the bias that is printed for it; four of five are found."""
    w, random = two_camera_world, np.random.default_rng(12)
    first = inspected(adjust_block(w.with_image_points(unequal(w, random)).block, ap_models.get("none")))
    # the printed bias hangs on the components that were found; the true ones are known here
    assert first.components is not None
    mdb = first.reliability.mdb[first.reliability.image_points].copy()
    for camera in FACTORS:
        at = first.components.names.index(f"images of {camera}")
        mdb[first.own[: len(mdb)] == at] *= FACTORS[camera] / first.components.sigma_factor[at]
    hits = 0
    for _ in range(BLOCKS):
        xy = unequal(w, random)
        row = int(random.integers(xy.size))
        xy.ravel()[row] += random.choice([-1.0, 1.0]) * mdb[row]
        found = inspected(adjust_block(w.with_image_points(xy).block, ap_models.get("none")), alpha=first.alpha)
        hits += row in found.suspected
    assert abs(hits / BLOCKS - 0.8) < ERRORS_MOST * np.sqrt(0.8 * 0.2 / BLOCKS)
