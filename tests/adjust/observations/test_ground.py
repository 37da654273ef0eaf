"""Distances and height differences: points that are tied to each other, in both arithmetics and against the full
matrices.
"""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Adjustment, Status, adjust_block, ap_models
from adjust.observations.ground import Distances, HeightDifferences
from adjust.observations.group import Group
from adjust.observations.stations import StationPositions
from adjust.quality.gross_errors import snoop
from adjust.quality.reliability import Reliability
from adjust.quality.significance import ap_significance
from adjust.quality.variance import variance_components
from adjust.solution.iteration import ERROR_LEFT
from tests import synthetic
from tests.adjust import dense

MODEL = ap_models.get("torlegard")
PAIRS = (("11", "16"), ("16", "33"), ("48", "12"), ("51", "47"), ("22", "34"))
SIGMA_M = 0.01


def true_lines(w: synthetic.World, pairs: tuple[tuple[str, str], ...] = PAIRS) -> np.ndarray:
    at = [[w.block.points.ids.index(name) for name in pair] for pair in pairs]
    return w.coordinates[np.array(at)[:, 1]] - w.coordinates[np.array(at)[:, 0]]


def measured(w: synthetic.World, rng: np.random.Generator) -> tuple[Distances, HeightDifferences]:
    lines, sigma = true_lines(w), np.full(len(PAIRS), SIGMA_M)
    return (
        Distances(PAIRS, np.linalg.norm(lines, axis=1) + rng.normal(0.0, SIGMA_M, len(lines)), sigma),
        HeightDifferences(PAIRS, lines[:, 2] + rng.normal(0.0, SIGMA_M, len(lines)), sigma),
    )


@pytest.fixture(scope="module")
def w(ww_world: synthetic.World) -> synthetic.World:
    """Control of all kinds among the tied points: 11 fixed in plan and weighted in height, 33 weighted, 51 fixed."""
    noisy = ww_world.with_noise(np.random.default_rng(5)).controlled(synthetic.CONTROL, (0.02, 0.02, 0.02))
    sigma = noisy.block.points.sigma.copy()
    sigma[noisy.block.points.ids.index("11")] = [0.0, 0.0, 0.02]
    sigma[noisy.block.points.ids.index("51")] = 0.0
    return noisy.with_points(sigma=sigma)


@pytest.fixture(scope="module")
def groups(w: synthetic.World) -> tuple[Group, ...]:
    rng = np.random.default_rng(6)
    gnss = w.exterior[:, :3] + rng.normal(0.0, 0.05, (12, 3))
    stations = StationPositions(w.block.images.ids, gnss, np.full((12, 3), 0.05), offset=True)
    return *measured(w, rng), stations


@pytest.fixture(scope="module")
def a(w: synthetic.World, groups: tuple[Group, ...]) -> Adjustment:
    return adjust_block(w.block, MODEL, observations=groups)


def full_design(a: Adjustment) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The design matrix with the columns of tied coordinates where they stand in x."""
    u = a.layout
    untied = type(u).of(a.block, MODEL, None, u.further)
    x = np.concatenate([a.x[: untied.orientation], u.points(a.x).ravel()])
    groups = type(a.groups).of(a.block, untied)
    design, v, weight = dense.design(groups, x)
    place = np.concatenate([np.arange(untied.orientation), u.places])
    wide = np.zeros((a.groups.rows, len(a.x)))
    wide[: len(v), place] = design
    start = len(v)
    for group in a.groups.further:
        at = group.at(a.x)
        for row, (columns, values) in enumerate(zip(at.columns, at.values, strict=True), start=start):
            np.add.at(wide[row], columns, values)
        v, weight, start = np.append(v, at.v), np.append(weight, group.weight), start + len(at.v)
    return wide, v, weight


def test_both_arithmetics_and_the_full_matrices(w: synthetic.World, groups: tuple[Group, ...], a: Adjustment) -> None:
    assert a.status.ok, a.message
    plain = adjust_block(w.block, MODEL, observations=groups, compiled=False)
    free = a.layout.free
    np.testing.assert_allclose((a.x - plain.x)[free] / a.std[free], 0.0, atol=2.0 * ERROR_LEFT)
    design, v, weight = full_design(a)
    assert np.sum(weight * v**2) == pytest.approx(a.vpv, rel=1e-12)
    root = np.sqrt(weight)
    hat, inverse_r = dense.factors(root[:, None] * design[:, free])
    q = inverse_r @ inverse_r.T
    std = np.sqrt(np.diag(q))
    np.testing.assert_allclose(inverse_r @ (hat.T @ (root * v)) / std, 0.0, atol=ERROR_LEFT)
    at = np.flatnonzero(free)
    for each in (a, plain):
        found = each.cofactors.block(at, at) / std / std[:, None]
        np.testing.assert_allclose(found, q / std / std[:, None], rtol=0.0, atol=dense.SAME)
        np.testing.assert_allclose(each.cofactors.diagonal[at], np.diag(q), rtol=dense.SAME)
        assert each.arithmetic.at(each.x).vpv == pytest.approx(a.vpv, rel=1e-10)
    r = 1.0 - np.sum(hat**2, axis=1)
    quality = Reliability.of(a)
    order = (2 * a.groups.image_points.order[:, None] + np.arange(2)).ravel()
    place = np.append(order, np.arange(len(order), len(r)))
    np.testing.assert_allclose(quality.redundancy[place], r, rtol=0.0, atol=dense.SAME)
    np.testing.assert_allclose(quality.w[place], root * v / np.sqrt(r), rtol=0.0, atol=dense.SAME)
    assert quality.redundancy.sum() == pytest.approx(a.redundancy, abs=len(r) * dense.SAME)


def test_counts_names_and_tables(w: synthetic.World, a: Adjustment) -> None:
    b = w.block
    assert a.observations == 2 * len(b.observations) + int(b.points.weighted.sum()) + 10 + 36
    assert a.unknowns == 6 * 12 + 6 + 3 + int((~b.points.fixed).sum())
    for name, axis in (("16", "X"), ("33", "Z"), ("11", "Z"), ("55", "Y")):
        at = a.layout.index(name, axis)
        assert a.layout.name(at) == f"{axis} of point {name}"
        row = b.points.ids.index(name)
        assert a.points.std[row, "XYZ".index(axis)] == a.std[at] > 0.0
        assert a.points.values[row, "XYZ".index(axis)] == pytest.approx(a.x[at] + a.layout.origin["XYZ".index(axis)])
    np.testing.assert_array_equal(a.points.std[b.points.fixed], 0.0)
    lines = np.array([a.coordinates[b.points.ids.index(q)] - a.coordinates[b.points.ids.index(p)] for p, q in PAIRS])
    given = a.groups.further[0].given
    np.testing.assert_allclose(np.linalg.norm(lines, axis=1) - given, a.groups.further[0].at(a.x).v, atol=1e-9)
    assert np.abs(np.linalg.norm(lines, axis=1) - given).max() < 5 * SIGMA_M
    assert Reliability.of(a).name(a.groups.rows - 36 - 10) == "distance 11 - 16"
    assert ap_significance(a, "ww").names == MODEL.parameters
    assert "distances" in variance_components(a).names


def test_without_any_weight_it_is_the_same_block(w: synthetic.World, groups: tuple[Group, ...]) -> None:
    alone = adjust_block(w.block, MODEL)
    loose = [type(g)(g.ends, g.values, 1e7 * g.sigma) for g in groups[:2]]  # type: ignore[attr-defined, call-arg]
    tied = adjust_block(w.block, MODEL, observations=loose)
    np.testing.assert_allclose(tied.coordinates, alone.coordinates, rtol=0.0, atol=1e-7)
    assert tied.vpv == pytest.approx(alone.vpv, rel=1e-9)
    np.testing.assert_allclose(tied.points.std / tied.sigma0, alone.points.std / alone.sigma0, rtol=1e-6, atol=1e-12)


def test_a_distance_gives_the_scale(ww_world: synthetic.World) -> None:
    """Two points held in plan and height give no scale when one of them is free: a distance does."""
    role = np.where(np.isin(ww_world.block.points.ids, ("11", "15", "55")), "control", "tie").tolist()
    sigma = np.full_like(ww_world.coordinates, np.nan)
    ids = ww_world.block.points.ids
    sigma[ids.index("11")] = 0.0
    sigma[ids.index("15"), 1:] = 0.0
    sigma[ids.index("55"), 2] = 0.0
    coordinates = np.where(np.isfinite(sigma), ww_world.coordinates, np.nan)
    w = ww_world.with_points(role=role, coordinates=coordinates, sigma=sigma).with_noise(np.random.default_rng(3))
    without = adjust_block(w.block)
    assert without.status is Status.SINGULAR
    assert "scale" in without.message
    pair = (("16", "49"),)
    length = np.linalg.norm(true_lines(ww_world, pair), axis=1)
    a = adjust_block(w.block, observations=[Distances(pair, length, np.array([0.01]))])
    assert a.status.ok, a.message
    assert np.sqrt(np.mean((a.coordinates - ww_world.coordinates) ** 2)) < 0.5


def test_a_height_difference_is_no_scale(ww_world: synthetic.World) -> None:
    nothing = np.full_like(ww_world.coordinates, np.nan)
    free = ww_world.with_points(role=["tie"] * len(nothing), coordinates=nothing, sigma=nothing)
    heights = HeightDifferences((("11", "15"),), np.zeros(1), np.ones(1))
    for compiled in (True, False):
        a = adjust_block(free.block, observations=[heights], compiled=compiled)
        assert a.status is Status.SINGULAR
        assert "free: " in a.message or "there is no control" in a.message, a.message


def test_a_wrong_distance_is_found(w: synthetic.World) -> None:
    distances, heights = measured(w, np.random.default_rng(6))
    distances.values[3] += 0.4
    found = snoop(adjust_block(w.block, MODEL, observations=[distances, heights]), 1e-5)
    assert [each.name for each in found.accused] == ["distance 51 - 47"]
    assert found.accused[0].error == pytest.approx(0.4, abs=0.15)


@pytest.mark.parametrize(
    ("pairs", "values", "sigma", "said"),
    [
        ((("11", "x"),), [1.0], [1.0], "distance 11 - x: there is no point 'x'"),
        ((("11", "11"),), [1.0], [1.0], "the ends are the same point"),
        ((("11", "15"),), [1.0, 2.0], [1.0], "1 pairs of points need 1 values"),
        ((("11", "15"),), [1.0], [0.0], "standard deviations > 0"),
    ],
)
def test_refusals(w: synthetic.World, pairs: object, values: list[float], sigma: list[float], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        adjust_block(w.block, observations=[Distances(pairs, np.array(values), np.array(sigma))])  # type: ignore[arg-type]
