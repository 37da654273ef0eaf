"""What adjusts again keeps datum, weights, further observations and arithmetic, and counts what is left."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from adjust import Adjustment, FreeAdjustment, InnerConstraints, MinimumControl, adjust_block, ap_models
from adjust.bundle import remodelled, reweighted
from adjust.normals import Plain
from adjust.observations import ApPriors, StationPositions
from adjust.quality import Danish, Huber, robust, snoop, variance_components
from adjust.quality.model_choice import delete_stepwise
from adjust.quality.robust_estimation import Cauchy, WeightFunction
from tests import synthetic

SAME = 1e-6
"""standard deviations, between two ways to one minimum"""
AGAIN: dict[str, Callable[[Adjustment], Adjustment]] = {
    "reweighted": lambda a: reweighted(a, a.groups.weights * 0.25),
    "snoop": lambda a: snoop(a).adjustment,
    "robust": lambda a: robust(a).adjustment,
    "variance components": lambda a: variance_components(a).adjustment,
    "stepwise": lambda a: delete_stepwise(a).adjustment,
    "other models": lambda a: remodelled(a, {c: ap_models.get("none") for c in ("ww", "sww")}),
}
SIGMAS_OUT = 12.0
ROUNDS = 20
ERRORS_MOST = 3.0
"""in Monte-Carlo standard errors"""
NOT_ALL_FOUND = 0.05
"""of the variance: good observations that lose their weight, too, are known to nobody"""


@pytest.fixture(scope="module")
def spoiled(two_camera_world: synthetic.World) -> synthetic.World:
    w = two_camera_world.with_noise(np.random.default_rng(5))
    xy = w.block.observations.xy.copy()
    xy[[5, 90], [0, 1]] += SIGMAS_OUT * synthetic.SIGMA_MM
    return w.with_image_points(xy)


@pytest.mark.parametrize("again", AGAIN.values(), ids=list(AGAIN))
@pytest.mark.parametrize("points", [(), ("datum",)], ids=["all points", "four points"])
def test_a_free_network_stays_one(
    spoiled: synthetic.World, again: Callable[[Adjustment], Adjustment], points: tuple[str, ...]
) -> None:
    block = spoiled.block
    if points:
        points = tuple(block.points.ids[i] for i in np.argsort(-block.rays)[:4])
    first = adjust_block(block, ap_models.get("optical"), datum=InnerConstraints(points))
    assert isinstance(first, FreeAdjustment)
    found = again(first)
    assert isinstance(found, FreeAdjustment)
    np.testing.assert_array_equal(found.datum_rows, first.datum_rows)
    # inner constraints hold: the datum points keep their targets in the mean, without a turn or a scale
    moved = found.coordinates[found.datum_rows] - first.targets
    away = found.coordinates[found.datum_rows]
    away = away - away.mean(axis=0)
    size = np.abs(away).max()
    np.testing.assert_allclose(moved.mean(axis=0), 0.0, atol=1e-8 * size)
    assert abs(np.sum(moved * away)) < 1e-6 * size * np.abs(moved).max() * len(away)
    np.testing.assert_allclose(
        np.cross(away, moved).sum(axis=0), 0.0, atol=1e-6 * size * np.abs(moved).max() * len(away)
    )
    # the precision is that of the inner datum, and the same as by tying its minimum again
    tied = first.tied(found.regular)
    np.testing.assert_allclose(found.points.std, tied.points.std, rtol=1e-9)
    trace = (found.points.std[found.datum_rows] ** 2).sum()
    assert trace < (found.regular.points.std[found.datum_rows] ** 2).sum()


@pytest.mark.parametrize("again", AGAIN.values(), ids=list(AGAIN))
def test_minimum_control_and_arithmetic_stay(
    spoiled: synthetic.World, again: Callable[[Adjustment], Adjustment]
) -> None:
    first = adjust_block(spoiled.block, ap_models.get("optical"), datum=MinimumControl(), compiled=False)
    found = again(first)
    np.testing.assert_array_equal(found.block.points.fixed, first.block.points.fixed)
    assert isinstance(found.arithmetic, Plain)


@pytest.mark.parametrize("again", AGAIN.values(), ids=list(AGAIN))
def test_further_observations_stay(spoiled: synthetic.World, again: Callable[[Adjustment], Adjustment]) -> None:
    block = spoiled.block
    ids = block.images.ids
    stations = StationPositions(ids, block.images.exterior[:, :3], np.full((len(ids), 3), 0.1))
    priors = ApPriors("ww", {"a3": (0.0, 1.0)})
    first = adjust_block(block, ap_models.get("optical"), observations=[stations, priors])
    found = again(first)
    assert found.status.ok
    kept = {group.name for group in found.groups.further}
    assert stations.bind(first.layout).name in kept


def test_deleted_parameters_do_not_bring_rejected_observations_back(spoiled: synthetic.World) -> None:
    first = snoop(adjust_block(spoiled.block, ap_models.get("brown14"))).adjustment
    out = np.flatnonzero(first.groups.weights == 0.0)
    assert len(out)
    found = delete_stepwise(first).adjustment
    np.testing.assert_array_equal(np.flatnonzero(found.groups.weights == 0.0), out)
    by_hand = remodelled(first, {s.id: s.model for s in found.layout.sets})
    np.testing.assert_allclose((found.coordinates - by_hand.coordinates), 0.0, atol=SAME)


def test_the_weights_of_priors_that_are_left_stay_theirs(spoiled: synthetic.World) -> None:
    model = ap_models.get("torlegard")
    names = model.parameters
    priors = ApPriors("ww", {names[0]: (0.0, 1.0), names[2]: (0.0, 2.0)})
    a = adjust_block(spoiled.block, model, observations=[priors])
    weights = a.groups.weights
    weights[-2:] = [0.5, 0.125]
    a = reweighted(a, weights)
    found = remodelled(a, {"ww": ap_models.without(model, names[0]), "sww": model})
    assert found.groups.weights[-1] == 0.125
    assert found.groups.rows == a.groups.rows - 1


@pytest.mark.parametrize("share", [0.05, 0.15])
def test_what_is_taken_out_is_not_counted(two_camera_world: synthetic.World, share: float) -> None:
    """Robust sigma0 and standard deviations are as if the observations were not there."""
    w = two_camera_world.with_noise(np.random.default_rng(8))
    o = w.block.observations
    random = np.random.default_rng(9)
    bad = random.permutation(2 * len(o))[: int(share * 2 * len(o))]
    xy = o.xy.copy()
    xy.ravel()[bad] += 300.0 * synthetic.SIGMA_MM * random.choice([-1.0, 1.0], len(bad))
    first = adjust_block(w.with_image_points(xy).block, ap_models.get("none"))
    found = robust(first)
    assert set(bad) <= {s.row for s in found.suspects}
    weights = first.groups.weights
    weights[found.factor < 0.5] = 0.0
    rest = reweighted(first, weights)
    gone = int(np.sum(found.factor < 0.5))
    assert found.adjustment.observations == found.adjustment.redundancy + found.adjustment.unknowns
    assert abs(found.adjustment.redundancy - (first.redundancy - gone)) <= 2
    assert found.adjustment.sigma0 == pytest.approx(rest.sigma0, rel=0.03)
    np.testing.assert_allclose(found.adjustment.points.std, rest.points.std, rtol=0.05)


@pytest.mark.parametrize(
    ("function", "least", "most"), [(Danish(), 1.0, 1.0), (Huber(), 0.0, 1.0), (Cauchy(), 0.0, 1.0)], ids=repr
)
def test_standard_deviations_of_robust_estimates_are_true(
    two_camera_world: synthetic.World, function: WeightFunction, least: float, most: float
) -> None:
    """Mean squares of errors over the variances that were told, five observations of a hundred spoiled.

    With functions that leave every gross error some weight the errors count in sigma0: there it is an upper bound.
    """
    w, random, ratio = two_camera_world, np.random.default_rng(77), []
    for _ in range(ROUNDS):
        xy = w.with_noise(random).block.observations.xy.copy()
        bad = random.permutation(xy.size)[: xy.size // 20]
        xy.ravel()[bad] += 40.0 * synthetic.SIGMA_MM * random.choice([-1.0, 1.0], len(bad))
        found = robust(adjust_block(w.with_image_points(xy).block), function).adjustment
        rows = found.points.std[:, 0] > 0.0
        ratio.append(np.mean(((found.coordinates - w.coordinates)[rows] / found.points.std[rows]) ** 2))
    mean, error = np.mean(ratio), np.std(ratio, ddof=1) / np.sqrt(len(ratio))
    assert least - ERRORS_MOST * error < mean < most + ERRORS_MOST * error + NOT_ALL_FOUND
