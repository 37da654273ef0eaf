"""Variance components against the textbook's traces, and on blocks whose noise is known."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Adjustment, adjust_block, ap_models
from adjust.bundle import reweighted
from adjust.quality.influence import Influence
from adjust.quality.variance import FACTOR_LEAST, _helmert, groups_by_camera, variance_components
from simfield.block.block import Block
from tests import synthetic
from tests.adjust import dense
from tests.adjust.quality.test_reliability import Textbook

FACTORS = {"ww": 0.7, "sww": 1.5}


def noisy(w: synthetic.World, seed: int) -> Block:
    """Noise of other standard deviations than the block states; control weighted, its errors as stated."""
    rng = np.random.default_rng(seed)
    w = w.controlled(synthetic.CONTROL, (0.02, 0.02, 0.03))
    o, b = w.block.observations, w.block
    factor = np.array([FACTORS[b.cameras[c].camera_id] for c in b.images.camera[o.image]])
    xy = o.xy + factor[:, None] * o.sigma * rng.standard_normal(o.xy.shape)
    coordinates = b.points.coordinates + np.nan_to_num(b.points.sigma) * rng.standard_normal(b.points.sigma.shape)
    return w.with_points(coordinates=coordinates).with_image_points(xy).block


@pytest.fixture(scope="module")
def adjusted(two_camera_world: synthetic.World) -> Adjustment:
    return adjust_block(noisy(two_camera_world, 1), ap_models.get("optical"))


def test_helmerts_matrix(adjusted: Adjustment) -> None:
    groups = groups_by_camera(adjusted)
    assert list(groups) == ["images of ww", "images of sww", "control"]
    label = np.empty(adjusted.groups.rows, dtype=int)
    for number, rows in enumerate(groups.values()):
        label[rows] = number
    book = Textbook.of(adjusted)
    root = np.sqrt(book.weight)
    r = book.r * root[:, None] / root
    expected = np.array([[np.sum(r[np.ix_(label == i, label == j)] ** 2) for j in range(3)] for i in range(3)])
    found, squares, count = _helmert(Influence.of(adjusted), label, 3)
    np.testing.assert_allclose(found, expected, rtol=dense.SAME, atol=0.0)
    np.testing.assert_allclose(squares, [np.sum((root * book.v)[label == i] ** 2) for i in range(3)], rtol=1e-10)
    np.testing.assert_array_equal(count, np.bincount(label))
    np.testing.assert_allclose(found.sum(axis=1), [np.diag(r)[label == i].sum() for i in range(3)], rtol=1e-10)


def test_the_cameras_get_their_own_noise(adjusted: Adjustment) -> None:
    found = variance_components(adjusted)
    assert found.converged
    assert found.adjustment.sigma0 == pytest.approx(1.0, abs=1e-6)
    assert found.redundancy.sum() == pytest.approx(adjusted.redundancy, abs=1e-6)
    for name, factor in (("images of ww", 0.7), ("images of sww", 1.5)):
        at = found.names.index(name)
        assert abs(found.sigma_factor[at] - factor) < 4.0 * found.sigma_factor_std[at]
        assert found.sigma_factor_std[at] == pytest.approx(factor / np.sqrt(2.0 * found.redundancy[at]), rel=0.05)


def test_at_the_solution_each_group_has_its_redundancy(adjusted: Adjustment) -> None:
    """v^T P v of every group equals its redundancy: the fixed point of Foerstner's iteration, too."""
    found = variance_components(adjusted)
    standard = Influence.of(found.adjustment).rows.standard
    for rows, redundancy in zip(groups_by_camera(adjusted).values(), found.redundancy, strict=True):
        assert np.sum(standard[rows] ** 2) == pytest.approx(redundancy, rel=1e-3)


def test_what_nothing_checks_is_held(ww_world: synthetic.World) -> None:
    w = ww_world.controlled(("11", "15", "55"), (0.02, 0.02, 0.02)).with_noise(np.random.default_rng(2))
    sigma = w.block.points.sigma.copy()
    sigma[w.block.points.ids.index("15"), :2] = np.nan
    found = variance_components(adjust_block(w.with_points(sigma=sigma).block))
    at = found.names.index("control")
    assert found.factor[at] == 1.0
    assert np.isnan(found.factor_std[at])
    assert found.redundancy[at] == pytest.approx(0.0, abs=1e-6)
    assert found.converged
    assert found.adjustment.sigma0 == pytest.approx(1.0, abs=1e-5)


def test_groups_of_ones_own(adjusted: Adjustment) -> None:
    k2 = 2 * len(adjusted.block.observations)
    found = variance_components(adjusted, {"x": np.arange(0, k2, 2), "y": np.arange(1, k2, 2)})
    assert found.names == ("x", "y")
    assert abs(found.sigma_factor[0] / found.sigma_factor[1] - 1.0) < 0.15
    with pytest.raises(ValueError, match="y: an observation"):
        variance_components(adjusted, {"x": np.arange(4), "y": np.arange(3, 9)})


@pytest.mark.parametrize("factor", [1e-3, 0.3, 40.0])
def test_converged_means_that_the_equations_hold(two_camera_world: synthetic.World, factor: float) -> None:
    """Also where the first steps are longer than what is allowed, and for groups with little redundancy."""
    w = two_camera_world.controlled(synthetic.CONTROL, (0.02, 0.02, 0.03)).with_noise(np.random.default_rng(6))
    k2 = 2 * len(w.block.observations)
    a = adjust_block(w.block)
    random = np.random.default_rng(7).permutation(k2)
    groups = {"many": random[6:], "few": random[:6]}
    xy = w.block.observations.xy.copy()
    a = adjust_block(w.with_image_points(xy).block)
    weights = a.groups.weights
    weights[groups["many"]] /= factor**2
    found = variance_components(reweighted(a, weights), groups)
    assert found.converged
    influence = Influence.of(found.adjustment)
    label = np.full(len(influence), 2)
    for number, rows in enumerate(groups.values()):
        label[rows] = number
    helmert, squares, _ = _helmert(influence, label, 3)
    at = np.flatnonzero(~found.held)
    theta = np.linalg.solve(
        helmert[np.ix_(at, at)], squares[at] - helmert[np.ix_(at, np.setdiff1d([0, 1, 2], at))].sum(axis=1)
    )
    np.testing.assert_allclose(theta, 1.0, atol=1e-4)
    assert 0 in at
    assert found.sigma_factor[0] * factor == pytest.approx(1.0, rel=0.2)


def test_a_group_without_errors_is_held(two_camera_world: synthetic.World) -> None:
    w = two_camera_world
    noisy = w.with_noise(np.random.default_rng(6))
    xy = noisy.block.observations.xy.copy()
    xy[::2] = w.block.observations.xy[::2]
    a = adjust_block(noisy.with_image_points(xy).block)
    rows = np.arange(xy.size).reshape(-1, 2)
    found = variance_components(a, {"noisy": rows[1::2].ravel(), "without": rows[::2].ravel()})
    assert found.converged
    assert found.held.tolist() == [False, True]
    assert found.factor[1] == pytest.approx(FACTOR_LEAST)
