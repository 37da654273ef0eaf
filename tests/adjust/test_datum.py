"""The datum: free networks, minimum control, S-transformations; the block itself is the same in all of them."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Adjustment, Status, adjust_block, ap_models
from adjust.datum import Datum, FreeAdjustment, InnerConstraints, MinimumControl, free_network
from adjust.model.rotation import rotation_matrices
from adjust.model.similarity import Similarity, angles_of
from adjust.quality.gross_errors import snoop
from adjust.quality.reliability import Reliability
from adjust.quality.significance import ap_significance
from adjust.solution.iteration import ERROR_LEFT
from simfield.block.block import Block
from tests import synthetic
from tests.adjust import dense

MODEL = ap_models.get("torlegard")
SAME_ESTIMATE = 2.0 * ERROR_LEFT
"""of two adjustments that end each by itself, in standard deviations; what is derived from them depends on them"""
DATUMS: dict[str, Datum] = {
    "seven coordinates": MinimumControl(),
    "seven others": MinimumControl(("12", "47", "36", "54")),
    "control points": InnerConstraints(),
    "three points": InnerConstraints(("16", "19", "48")),
    "five points": InnerConstraints(("16", "19", "48", "46", "33")),
}


@pytest.fixture(scope="module")
def block(ww_world: synthetic.World) -> Block:
    return ww_world.with_noise(np.random.default_rng(9)).controlled(synthetic.CONTROL, (0.02, 0.02, 0.02)).block


@pytest.fixture(scope="module")
def all_of_them(block: Block) -> dict[str, Adjustment]:
    return {name: adjust_block(block, MODEL, datum=datum) for name, datum in DATUMS.items()}


def test_the_same_block_in_every_datum(all_of_them: dict[str, Adjustment]) -> None:
    first = all_of_them["seven coordinates"]
    assert first.status.ok, first.message
    quality = Reliability.of(first)
    for a in all_of_them.values():
        assert a.status.ok, a.message
        np.testing.assert_allclose(a.residuals, first.residuals, rtol=0.0, atol=1e-11)
        assert a.sigma0 == pytest.approx(first.sigma0, rel=1e-9)
        assert a.redundancy == first.redundancy
        difference = (a.ap["ww"].values - first.ap["ww"].values) / first.ap["ww"].std
        np.testing.assert_allclose(difference, 0.0, atol=SAME_ESTIMATE)
        np.testing.assert_allclose(a.ap["ww"].std, first.ap["ww"].std, rtol=SAME_ESTIMATE)
        np.testing.assert_allclose(Reliability.of(a).redundancy, quality.redundancy, rtol=0.0, atol=SAME_ESTIMATE)
        np.testing.assert_allclose(Reliability.of(a).w, quality.w, rtol=0.0, atol=SAME_ESTIMATE)
        found = ap_significance(a, "ww")
        np.testing.assert_allclose(found.z, ap_significance(first, "ww").z, rtol=0.0, atol=SAME_ESTIMATE)


def test_counts(all_of_them: dict[str, Adjustment]) -> None:
    minimum, free = all_of_them["seven coordinates"], all_of_them["three points"]
    assert isinstance(free, FreeAdjustment)
    assert int(minimum.block.points.fixed.sum()) == 7
    assert free.unknowns == minimum.unknowns + 7
    assert not free.block.points.fixed.any()


@pytest.mark.parametrize("name", ["three points", "five points", "control points"])
def test_cofactors_are_those_of_the_definition(all_of_them: dict[str, Adjustment], name: str) -> None:
    """All of them, in units of the standard deviations."""
    a = all_of_them[name]
    assert isinstance(a, FreeAdjustment)
    expected, q, everything = dense.free_network(a), a.cofactors, np.arange(len(a.x))
    std = np.sqrt(np.diag(expected))
    found = q.block(everything, everything)
    np.testing.assert_allclose(found / std / std[:, None], expected / std / std[:, None], rtol=0.0, atol=dense.SAME)
    np.testing.assert_allclose(q.diagonal, np.diag(expected), rtol=dense.SAME)
    size = a.layout.orientation
    np.testing.assert_allclose(
        (q.orientation - expected[:size, :size]) / std[:size] / std[:size, None], 0.0, atol=dense.SAME
    )
    points = std[size:].reshape(-1, 3)
    blocks = np.array([expected[i : i + 3, i : i + 3] for i in range(size, len(std), 3)])
    scaled = (q.points - blocks) / points[:, None, :] / points[:, :, None]
    np.testing.assert_allclose(scaled, 0.0, atol=dense.SAME)


def test_the_datum_points_stay_in_the_mean(block: Block, all_of_them: dict[str, Adjustment]) -> None:
    a = all_of_them["control points"]
    rows = block.points.role == "control"
    moved = a.coordinates[rows] - block.points.coordinates[rows]
    np.testing.assert_allclose(moved.mean(axis=0), 0.0, atol=1e-6)
    again = Similarity.between(a.coordinates[rows], block.points.coordinates[rows])
    assert again.scale == pytest.approx(1.0, abs=1e-9)
    np.testing.assert_allclose(again.turn, np.eye(3), rtol=0.0, atol=1e-9)


def test_it_has_the_smallest_trace(all_of_them: dict[str, Adjustment]) -> None:
    rows = np.flatnonzero(np.isin(all_of_them["five points"].block.points.ids, ("16", "19", "48", "46", "33")))
    trace = {name: float(np.sum(a.points.std[rows] ** 2)) for name, a in all_of_them.items()}
    assert min(trace, key=lambda name: trace[name]) == "five points"


def test_one_datum_from_another(block: Block, all_of_them: dict[str, Adjustment]) -> None:
    """S-transformed from the free network of other points, or adjusted anew: the same."""
    expected = all_of_them["five points"]
    rows = np.flatnonzero(np.isin(block.points.ids, ("16", "19", "48", "46", "33")))
    found = free_network(all_of_them["three points"], rows, expected.coordinates[rows])
    difference = (found.coordinates - expected.coordinates) / expected.points.std
    np.testing.assert_allclose(difference, 0.0, atol=SAME_ESTIMATE)
    np.testing.assert_allclose(found.points.std, expected.points.std, rtol=SAME_ESTIMATE)
    np.testing.assert_allclose(found.images.std, expected.images.std, rtol=SAME_ESTIMATE)


def test_minimum_control_equals_the_free_network_up_to_a_similarity(all_of_them: dict[str, Adjustment]) -> None:
    a, b = all_of_them["seven coordinates"].coordinates, all_of_them["three points"].coordinates
    np.testing.assert_allclose(Similarity.between(a, b).points(a), b, rtol=0.0, atol=1e-6)


def test_no_control_at_all(ww_world: synthetic.World) -> None:
    nothing = np.full_like(ww_world.coordinates, np.nan)
    tie = ["tie"] * len(nothing)
    w = ww_world.with_points(role=tie, coordinates=nothing, sigma=nothing).with_noise(np.random.default_rng(1))
    assert adjust_block(w.block).status is Status.SINGULAR
    a = adjust_block(w.block, datum=InnerConstraints())
    assert a.status.ok, a.message
    assert len(a.datum_rows) == len(w.block.points)  # type: ignore[attr-defined]
    error = Similarity.between(a.coordinates, w.coordinates).points(a.coordinates) - w.coordinates
    assert np.sqrt(np.mean(error**2)) < 0.3


def test_gross_errors_in_a_free_network(block: Block) -> None:
    xy = block.observations.xy.copy()
    xy[17, 1] += 15.0 * synthetic.SIGMA_MM
    a = adjust_block(block.replace_image_points(xy), MODEL, datum=InnerConstraints())
    assert [each.row for each in snoop(a, 1e-5).accused] == [35]


class TestRefusals:
    def test_too_few_points(self, block: Block) -> None:
        a = adjust_block(block, datum=InnerConstraints(("16", "19")))
        assert a.status is Status.NO_START
        assert "a datum needs three points or more, there are 2" in a.message

    def test_unknown_points(self, block: Block) -> None:
        a = adjust_block(block, datum=MinimumControl(("16", "19", "nobody")))
        assert "point 'nobody' of the datum is not in the block" in a.message

    def test_points_on_a_line(self, vertical_world: synthetic.World) -> None:
        coordinates = vertical_world.coordinates
        w = vertical_world.with_points(coordinates=coordinates)
        a = adjust_block(w.block, datum=InnerConstraints(("11", "12", "13", "15")))
        assert a.status is Status.NO_START
        assert "the points of the datum lie on a line" in a.message

    def test_more_than_minimum_control(self, block: Block) -> None:
        with pytest.raises(ValueError, match="only an adjustment on minimum control"):
            free_network(adjust_block(block), np.arange(5), np.zeros((5, 3)))


def test_angles_come_back() -> None:
    angles = np.random.default_rng(1).uniform([-3.0, -1.5, -3.0], [3.0, 1.5, 3.0], (50, 3))
    np.testing.assert_allclose(angles_of(rotation_matrices(angles)), angles, rtol=0.0, atol=1e-12)
