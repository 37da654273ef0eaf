"""Free networks with distances: the bars give the scale, six motions are left free."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

from adjust import Adjustment, FreeAdjustment, InnerConstraints, MinimumControl, adjust_block, ap_models
from adjust.datum import Datum, free_network
from adjust.observations import Distances, HeightDifferences, Observations
from adjust.quality import Reliability, inspected, variance_components
from simfield.block import Block, Floats
from tests import synthetic

MODEL = ap_models.get("optical")
SIGMA_M = 0.01
SAME = 1e-8
"""sigma0 of two adjustments that each end within 1e-9 standard deviations"""
BY_DIFFERENCES = 1e-4
"""share of a standard deviation, with derivatives by differences"""
DATUMS: dict[str, Datum] = {
    "six coordinates": MinimumControl(),
    "six others": MinimumControl(("12", "47", "36", "54")),
    "all control": InnerConstraints(),
    "three points": InnerConstraints(("16", "19", "48")),
}


@pytest.fixture(scope="module")
def block(ww_world: synthetic.World) -> Block:
    return ww_world.with_noise(np.random.default_rng(9)).block


@pytest.fixture(scope="module")
def bars(ww_world: synthetic.World) -> Distances:
    ids, at = ww_world.block.points.ids, ww_world.coordinates
    pairs = [("12", "47"), ("16", "48"), ("33", "19"), ("12", "19")]
    lengths = np.array([np.linalg.norm(at[ids.index(a)] - at[ids.index(b)]) for a, b in pairs])
    # bars of 100 m and more, all by a thousandth longer than control says: they alone give the scale
    noise = np.random.default_rng(1).standard_normal(len(pairs))
    return Distances(tuple(pairs), 1.001 * lengths + SIGMA_M * noise, np.full(len(pairs), SIGMA_M))


@pytest.fixture(scope="module")
def all_of_them(block: Block, bars: Distances) -> dict[str, Adjustment]:
    return {name: adjust_block(block, MODEL, datum=datum, observations=[bars]) for name, datum in DATUMS.items()}


def test_the_same_block_in_every_datum(all_of_them: dict[str, Adjustment]) -> None:
    first = all_of_them["six coordinates"]
    assert first.status.ok, first.message
    quality = Reliability.of(first)
    for a in all_of_them.values():
        assert a.status.ok, a.message
        np.testing.assert_allclose(a.residuals, first.residuals, atol=1e-10)
        assert a.sigma0 == pytest.approx(first.sigma0, rel=SAME)
        assert a.redundancy == first.redundancy == a.observations - a.unknowns + (6 if a is not a.regular else 0)
        np.testing.assert_allclose(a.ap["ww"].std, first.ap["ww"].std, rtol=1e-6)
        np.testing.assert_allclose(Reliability.of(a).redundancy, quality.redundancy, atol=1e-7)


def test_the_bars_give_the_scale(all_of_them: dict[str, Adjustment], ww_world: synthetic.World) -> None:
    true, at = ww_world.coordinates, np.array([0, 7, 20, 33])
    for a in all_of_them.values():
        shape = np.linalg.norm(a.coordinates[at] - a.coordinates[at[::-1]], axis=1)
        assert np.mean(shape / np.linalg.norm(true[at] - true[at[::-1]], axis=1)) == pytest.approx(1.001, abs=1e-4)


def test_inner_constraints_hold_without_scale(all_of_them: dict[str, Adjustment]) -> None:
    a = all_of_them["three points"]
    assert isinstance(a, FreeAdjustment)
    assert a.rank_defect == 6
    found = a.coordinates[a.datum_rows]
    moved, away = found - a.targets, found - found.mean(axis=0)
    np.testing.assert_allclose(moved.mean(axis=0), 0.0, atol=1e-7)
    np.testing.assert_allclose(np.cross(away, moved).sum(axis=0), 0.0, atol=1e-3 * np.abs(away).max() * 1e-3)
    assert np.abs(moved).max() > 0.1, "the points went apart by the scale of the bars"


def test_cofactors_are_those_of_the_definition(all_of_them: dict[str, Adjustment]) -> None:
    """N^-1 in the space of changes that neither shift nor turn the datum points, derivatives by differences."""
    a = all_of_them["three points"]
    assert isinstance(a, FreeAdjustment)
    groups = Observations.of(a.block, a.layout, a.groups.stated)

    def residuals(x: Floats) -> Floats:
        v, _ = groups.image_points.residuals(x)
        return np.concatenate([v.ravel(), *(group.at(x).v for group in groups.further)])

    free = np.flatnonzero(a.layout.free)
    std = np.where(a.std > 0.0, a.std, 1.0)
    weights = np.concatenate([groups.image_points.weight.ravel(), *(group.weight for group in groups.further)])
    design = np.empty((len(weights), len(free)))
    for column, at in enumerate(free):
        there, back = a.x.copy(), a.x.copy()
        there[at] += std[at]
        back[at] -= std[at]
        design[:, column] = np.sqrt(weights) * (residuals(there) - residuals(back)) / 2.0
    condition = np.zeros((len(a.x), 6))
    away = a.layout.points(a.x)[a.datum_rows]
    away = (away - away.mean(axis=0)) / np.ptp(away)
    for row, (x, y, z) in zip(a.datum_rows, away, strict=True):
        i, j, k = a.layout.places[3 * row : 3 * row + 3]
        condition[i], condition[j], condition[k] = (1, 0, 0, 0, z, -y), (0, 1, 0, -z, 0, x), (0, 0, 1, y, -x, 0)
    allowed = scipy.linalg.null_space((condition[free] * std[free, None]).T)
    expected = allowed @ np.linalg.inv(allowed.T @ design.T @ design @ allowed) @ allowed.T
    found = a.cofactors.block(free, free) / std[free] / std[free, None]
    np.testing.assert_allclose(found * a.sigma0**2, expected * a.sigma0**2, atol=BY_DIFFERENCES)
    np.testing.assert_allclose(a.cofactors.diagonal[free] / std[free] ** 2, np.diag(expected), rtol=BY_DIFFERENCES)


def test_one_datum_from_another(block: Block, all_of_them: dict[str, Adjustment]) -> None:
    expected = all_of_them["three points"]
    assert isinstance(expected, FreeAdjustment)
    found = free_network(all_of_them["all control"], expected.datum_rows, expected.targets)
    np.testing.assert_allclose((found.coordinates - expected.coordinates) / expected.points.std, 0.0, atol=1e-7)
    np.testing.assert_allclose(found.points.std, expected.points.std, rtol=1e-6)


def test_quality_control_keeps_the_datum(all_of_them: dict[str, Adjustment]) -> None:
    a = all_of_them["three points"]
    for found in (variance_components(a).adjustment, inspected(a).adjustment):
        assert isinstance(found, FreeAdjustment)
        assert found.rank_defect == 6


def test_both_arithmetics(block: Block, bars: Distances) -> None:
    a, b = (
        adjust_block(block, MODEL, datum=InnerConstraints(), observations=[bars], compiled=c) for c in (True, False)
    )
    np.testing.assert_allclose(a.coordinates, b.coordinates, atol=1e-7)
    np.testing.assert_allclose(a.points.std, b.points.std, rtol=1e-7)


def test_heights_are_still_refused(block: Block) -> None:
    levelled = HeightDifferences((("12", "47"),), np.array([0.0]), np.array([0.01]))
    a = adjust_block(block, MODEL, datum=InnerConstraints(), observations=[levelled])
    assert "a free network cannot hold observed stations or height differences" in a.message
