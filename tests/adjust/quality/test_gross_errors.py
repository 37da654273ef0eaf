"""Data snooping and robust estimation on blocks whose errors are known, and against the textbook's formulas."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Adjustment, adjust_block, ap_models
from adjust.bundle import reweighted
from adjust.quality.gross_errors import LEAST_CHECKED, _Search, snoop
from adjust.quality.reliability import Reliability, familywise, tau_critical, w_critical
from adjust.quality.robust_estimation import Cauchy, Danish, Huber, WeightFunction, robust
from simfield.block.block import Floats
from tests import synthetic
from tests.adjust import dense

PLANTED = {(5, 0): 12.0, (40, 1): -9.0, (41, 1): 15.0, (100, 0): 20.0, (160, 1): -8.0}
"""(observation, x or y): error in standard deviations; 40 and 41 stand side by side in one image"""
ROWS = {2 * k + axis for k, axis in PLANTED}


def spoiled(w: synthetic.World, planted: dict[tuple[int, int], float] = PLANTED) -> synthetic.World:
    xy = w.block.observations.xy.copy()
    for (k, axis), size in planted.items():
        xy[k, axis] += size * synthetic.SIGMA_MM
    return w.with_image_points(xy)


@pytest.fixture(scope="module")
def noisy(two_camera_world: synthetic.World) -> synthetic.World:
    return two_camera_world.with_noise(np.random.default_rng(31))


@pytest.fixture(scope="module")
def wrong(noisy: synthetic.World) -> Adjustment:
    return adjust_block(spoiled(noisy).block, ap_models.get("torlegard"))


@pytest.fixture(scope="module")
def right(noisy: synthetic.World) -> Adjustment:
    return adjust_block(noisy.block, ap_models.get("torlegard"))


class TestReweighting:
    def test_other_weights_are_another_block(self, noisy: synthetic.World, right: Adjustment) -> None:
        o = noisy.block.observations
        factor = np.random.default_rng(1).uniform(0.5, 3.0, o.xy.shape)
        block = type(noisy.block)(
            noisy.block.cameras,
            noisy.block.images,
            noisy.block.points,
            type(o)(o.image, o.point, o.xy, o.sigma * factor),
        )
        expected = adjust_block(block, ap_models.get("torlegard"))
        found = reweighted(right, (1.0 / (o.sigma * factor) ** 2).ravel())
        assert found.status.ok
        np.testing.assert_allclose((found.x - expected.x) / np.maximum(expected.std, 1e-30), 0.0, atol=1e-7)
        assert found.sigma0 == pytest.approx(expected.sigma0, rel=1e-9)

    def test_weight_zero_is_out(self, noisy: synthetic.World, right: Adjustment) -> None:
        weights = right.groups.weights
        weights[[10, 11]] = 0.0
        found = reweighted(right, weights)
        o = noisy.block.observations
        kept = np.arange(len(o)) != 5
        block = type(noisy.block)(
            noisy.block.cameras,
            noisy.block.images,
            noisy.block.points,
            type(o)(o.image[kept], o.point[kept], o.xy[kept], o.sigma[kept]),
        )
        expected = adjust_block(block, ap_models.get("torlegard"))
        assert found.redundancy == expected.redundancy == right.redundancy - 2
        assert found.sigma0 == pytest.approx(expected.sigma0, rel=1e-9)
        np.testing.assert_allclose(found.std, expected.std, rtol=1e-7)
        assert Reliability.of(found).redundancy.sum() - 2.0 == pytest.approx(found.redundancy, abs=1e-8)


class TestSnooping:
    @pytest.mark.parametrize("test", ["w", "tau"])
    def test_all_are_found_and_nobody_else(self, wrong: Adjustment, test: str) -> None:
        found = snoop(wrong, familywise(0.05, wrong.observations), test)  # type: ignore[arg-type]
        assert {each.row for each in found.accused} == ROWS
        assert not found.stopped
        sizes = [abs(each.statistic) for each in found.accused]
        assert sizes[0] == max(sizes)
        for each in found.accused:
            k, axis = divmod(each.row, 2)
            sigma = synthetic.SIGMA_MM / np.sqrt(each.redundancy)
            assert abs(each.error - PLANTED[k, axis] * synthetic.SIGMA_MM) < 4.0 * sigma
            assert each.statistic > each.critical

    def test_the_rest_is_as_if_they_had_never_been(self, wrong: Adjustment, noisy: synthetic.World) -> None:
        found = snoop(wrong, familywise(0.05, wrong.observations)).adjustment
        other = snoop(
            adjust_block(
                spoiled(noisy, {key: 3.0 * v for key, v in PLANTED.items()}).block, ap_models.get("torlegard")
            ),
            familywise(0.05, wrong.observations),
        ).adjustment
        assert found.redundancy == wrong.redundancy - len(PLANTED)
        # not to the last digit: a wrong x goes on saying where the distortion of its y is taken
        assert found.sigma0 == pytest.approx(other.sigma0, rel=1e-6)
        np.testing.assert_allclose(found.coordinates, other.coordinates, rtol=0.0, atol=1e-4)

    def test_nothing_to_find(self, right: Adjustment) -> None:
        found = snoop(right, familywise(0.01, right.observations))
        assert found.accused == ()
        assert found.adjustment is right

    def test_the_downdates_are_adjustments(self, wrong: Adjustment) -> None:
        """Corrections and redundancy numbers after taking rows out, against the full matrices without these rows."""
        search = _Search(Reliability.of(wrong), np.full(wrong.groups.rows, -1), 0.001)
        out = [10, 81, 83]
        for row in out:
            search.take_out(row)
        weights = wrong.groups.weights
        weights[out] = 0.0
        again = Reliability.of(reweighted(wrong, weights))
        kept = np.setdiff1d(np.arange(len(again)), out)
        np.testing.assert_allclose(search.redundancy[kept], again.redundancy[kept], rtol=0.0, atol=2e-4)
        np.testing.assert_allclose(search.standard[kept], again.influence.rows.standard[kept], rtol=0.0, atol=5e-3)

    def test_the_downdates_are_the_textbook(self, wrong: Adjustment) -> None:
        design, v, weight = dense.design(wrong.groups, wrong.x)
        k2 = 2 * len(wrong.block.observations)
        order = (2 * wrong.groups.image_points.order[:, None] + np.arange(2)).ravel()
        place = np.empty(k2, dtype=int)
        place[order] = np.arange(k2)
        free = wrong.layout.free
        a = (design * np.sqrt(weight)[:, None])[place][:, free]
        out = [10, 81, 83]
        kept = np.setdiff1d(np.arange(k2), out)
        q, _ = np.linalg.qr(a[kept] / np.linalg.norm(a[kept], axis=0))
        r = np.eye(len(kept)) - q @ q.T
        search = _Search(Reliability.of(wrong), np.full(wrong.groups.rows, -1), 0.001)
        for row in out:
            search.take_out(row)
        np.testing.assert_allclose(search.redundancy[kept], np.diag(r), rtol=0.0, atol=dense.SAME)
        np.testing.assert_allclose(
            search.standard[kept], r @ (np.sqrt(weight) * v)[place][kept], rtol=0.0, atol=dense.SAME
        )
        assert float(search.standard @ search.standard) == pytest.approx(np.sum(search.standard**2), rel=1e-12)

    def test_two_rays_cannot_tell_who_is_wrong(self, ww_world: synthetic.World) -> None:
        """Of a point in two images one y is wrong: it is seen, and said that it could be the other one."""
        w = ww_world
        o = w.block.observations
        name = int(np.flatnonzero((w.block.points.role == "tie") & (w.block.rays > 4))[0])
        rays = np.flatnonzero(o.point == name)[:2]
        kept = (o.point != name) | np.isin(np.arange(len(o)), rays)
        block = type(w.block)(
            w.block.cameras,
            w.block.images,
            w.block.points,
            type(o)(o.image[kept], o.point[kept], o.xy[kept], o.sigma[kept]),
        )
        row = int(np.flatnonzero(block.observations.point == name)[0])
        xy = block.observations.xy.copy()
        xy[row] += 40.0 * synthetic.SIGMA_MM
        found = snoop(adjust_block(block.replace_image_points(xy)))
        assert found.accused
        assert any(block.points.ids[name] in text for text in found.accused[0].confused_with)
        assert all(each.redundancy > LEAST_CHECKED for each in found.accused)

    def test_a_limit(self, wrong: Adjustment) -> None:
        found = snoop(wrong, most=2)
        assert found.stopped
        assert len(found.accused) == 2
        assert found.adjustment.redundancy == wrong.redundancy - 2


class TestRobust:
    @pytest.mark.parametrize("function", [Huber(), Danish(), Cauchy()])
    def test_the_planted_errors_are_the_worst(self, wrong: Adjustment, function: WeightFunction) -> None:
        found = robust(wrong, function)
        assert found.converged
        assert {each.row for each in found.suspects[: len(ROWS)]} == ROWS
        assert [s.statistic for s in found.suspects] == sorted((s.statistic for s in found.suspects), reverse=True)
        for each in found.suspects[: len(ROWS)]:
            assert each.error == pytest.approx(PLANTED[divmod(each.row, 2)] * synthetic.SIGMA_MM, abs=0.02)
            assert each.factor < 0.35

    def test_weights_are_their_own_fixed_point(self, wrong: Adjustment) -> None:
        found = robust(wrong, Cauchy())
        np.testing.assert_allclose(Cauchy()(found.statistic), found.factor, rtol=0.0, atol=2e-3)

    def test_it_is_nearer_to_the_truth(self, wrong: Adjustment, two_camera_world: synthetic.World) -> None:
        def error(a: Adjustment) -> float:
            return float(np.sqrt(np.mean((a.coordinates - two_camera_world.coordinates) ** 2)))

        assert error(robust(wrong).adjustment) < 0.95 * error(wrong)

    @pytest.mark.parametrize("function", [Huber(), Danish(), Cauchy()])
    def test_weight_functions(self, function: WeightFunction) -> None:
        u = np.linspace(0.0, 30.0, 301)
        f = function(u)
        assert f[0] == 1.0
        assert (np.diff(f) <= 0.0).all()
        assert (f >= 0.0).all()
        assert np.abs(np.diff(f)).max() < 0.12, "continuous"

    def test_few_lose_weight_without_errors(self, right: Adjustment) -> None:
        found = robust(right, Danish())
        assert np.mean(found.factor < 0.5) < 0.01
        assert found.scale == pytest.approx(1.0, abs=0.08)


def test_masking_of_one_error_by_another(noisy: synthetic.World) -> None:
    """Errors of the same size in all rays but two of a point: what one round would accuse wrongly, the search puts
    right.
    """
    row = {(k, 1): 30.0 for k in (5, 40)}
    found = snoop(adjust_block(spoiled(noisy, row).block, ap_models.get("torlegard")), 0.0001)
    assert {each.row for each in found.accused} == {11, 81}


def test_critical_values_are_those_of_the_level(wrong: Adjustment) -> None:
    found = snoop(wrong, 0.0005, "tau", most=3)
    first: Floats = np.array([each.critical for each in found.accused])
    np.testing.assert_allclose(first, [tau_critical(wrong.redundancy - i, 0.0005) for i in range(3)], rtol=1e-12)
    assert snoop(wrong, 0.0005, most=1).accused[0].critical == w_critical(0.0005)
