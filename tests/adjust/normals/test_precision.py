"""Standard deviations, covariances and correlations of what was asked for; and what must have no influence."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Adjustment, adjust_block, ap_models
from simfield.block.block import Block, Floats, ImageObservations, Points
from tests import synthetic
from tests.adjust import dense

RELATIVE_TOLERANCE = dense.SAME

NAMES = [
    ("ww", "a3"),
    ("ww-2", "Z0"),
    ("sww", "a6"),
    ("sww-12", "kappa"),
    ("16a", "Z"),
    ("16a", "X"),
    ("16", "Z"),
    ("ww", "a1"),
    ("49", "Y"),
    ("15", "Z"),
]
"""of all kinds, in no order; 15 is weighted control"""


@pytest.fixture(scope="module")
def noisy(two_camera_world: synthetic.World) -> synthetic.World:
    w = two_camera_world.with_noise(np.random.default_rng(12))
    sigma = w.block.points.sigma.copy()
    sigma[w.block.points.ids.index("15")] = [0.01, 0.0, 0.03]
    return w.with_points(sigma=sigma)


@pytest.fixture(scope="module")
def adjusted(noisy: synthetic.World) -> Adjustment:
    a = adjust_block(noisy.block, ap_models.get("torlegard"))
    assert a.status.ok, a.message
    return a


@pytest.fixture(scope="module")
def inverse(adjusted: Adjustment) -> Floats:
    return dense.solve(adjusted.groups, adjusted.x).inverse


class TestCovariance:
    def test_of_arbitrary_names(self, adjusted: Adjustment, inverse: Floats) -> None:
        at = [adjusted.layout.index(*name) for name in NAMES]
        expected = adjusted.sigma0**2 * inverse[np.ix_(at, at)]
        std = np.sqrt(np.diag(expected))
        difference = np.abs(adjusted.covariance(*NAMES) - expected)
        assert (difference <= RELATIVE_TOLERANCE * std * std[:, None]).all()
        np.testing.assert_allclose(
            adjusted.correlation(*NAMES), expected / std / std[:, None], rtol=0.0, atol=RELATIVE_TOLERANCE
        )

    def test_names_lead_to_their_unknowns(self, adjusted: Adjustment) -> None:
        for owner, name in NAMES:
            said = adjusted.layout.name(adjusted.layout.index(owner, name))
            assert said.startswith(f"{name} of ")
            assert said.endswith(f" {owner}")

    def test_every_unknown_has_its_own_name(self, adjusted: Adjustment) -> None:
        names = [adjusted.layout.name(i) for i in range(len(adjusted.x))]
        assert len(set(names)) == len(names)
        with pytest.raises(IndexError):
            adjusted.layout.name(-7 * len(names))

    def test_it_is_marginal(self, adjusted: Adjustment) -> None:
        """Fixing the orientations would make the parameters look better than they are."""
        at = slice(6 * len(adjusted.block.images), adjusted.layout.orientation)
        from adjust.normals.normals import assemble

        conditional = 1.0 / np.sqrt(np.diag(assemble(adjusted.groups, adjusted.x).ee)[at])
        assert (adjusted.std[at] > 1.5 * adjusted.sigma0 * conditional).all()

    def test_the_same_numbers_everywhere(self, adjusted: Adjustment) -> None:
        a = adjusted
        variances = np.diag(a.covariance(("ww", "a3"), ("sww-12", "kappa"), ("16a", "Z")))
        at = a.ap["ww"].names.index("a3")
        shown = [a.ap["ww"].std[at], a.images.std[-1, 5], a.points.std[a.points.ids.index("16a"), 2]]
        np.testing.assert_allclose(np.sqrt(variances), shown, rtol=1e-12)
        assert a.ap["ww"]["a3"] == a.ap["ww"].values[at]

    def test_a_matrix_of_one_camera(self, adjusted: Adjustment) -> None:
        r = adjusted.ap_correlation("sww")
        np.testing.assert_allclose(np.diag(r), 1.0, rtol=1e-14)
        np.testing.assert_allclose(r, r.T, rtol=0.0, atol=1e-14)
        assert np.linalg.eigvalsh(r)[0] > 0.0
        assert r[2, 3] < -0.7, "a3 and a4 have always been correlated"

    def test_fixed_coordinates_have_no_variance(self, adjusted: Adjustment) -> None:
        names = (("11", "X"), ("15", "Y"), ("15", "X"))
        covariance = adjusted.covariance(*names)
        np.testing.assert_array_equal(covariance[:2], 0.0)
        assert covariance[2, 2] > 0.0
        r = adjusted.correlation(*names)
        assert np.isnan(r[:2]).all()
        assert r[2, 2] == pytest.approx(1.0, rel=1e-14)

    @pytest.mark.parametrize("name", [("ww", "a7"), ("nobody", "X"), ("ww-1", "X"), ("11", "X0"), ("none", "a3")])
    def test_unknown_names(self, adjusted: Adjustment, name: tuple[str, str]) -> None:
        with pytest.raises(KeyError, match=f"no unknown '{name[1]}' of '{name[0]}'"):
            adjusted.correlation(name)

    def test_an_image_and_a_point_of_the_same_name(self, noisy: synthetic.World) -> None:
        """Ids are unique in their table, not among tables; the name of the unknown tells."""
        b = noisy.block
        ids = ("ww-1", *b.points.ids[1:])
        points = Points(ids, b.points.role, b.points.coordinates, b.points.sigma)
        a = adjust_block(Block(b.cameras, b.images, points, b.observations))
        assert a.layout.index("ww-1", "X0") == 0
        assert a.layout.index("ww-1", "X") == a.layout.orientation


class TestCounts:
    def test_counts(self, adjusted: Adjustment) -> None:
        b = adjusted.block
        assert adjusted.observations == 2 * len(b.observations) + 2
        assert adjusted.unknowns == 6 * 24 + 2 * 6 + 3 * (len(b.points) - 5) + 2
        assert adjusted.redundancy == adjusted.observations - adjusted.unknowns

    def test_unit_weight(self, adjusted: Adjustment) -> None:
        assert adjusted.unit_weight_um == pytest.approx(1000.0 * synthetic.SIGMA_MM, rel=1e-14)
        assert adjusted.m0_um == pytest.approx(adjusted.sigma0 * 4.0, rel=1e-14)
        assert 0.9 < adjusted.sigma0 < 1.1

    def test_residuals_stand_in_the_order_of_the_block(self, noisy: synthetic.World, adjusted: Adjustment) -> None:
        o = noisy.block.observations
        shuffled = np.random.default_rng(1).permutation(len(o))
        mixed = ImageObservations(o.image[shuffled], o.point[shuffled], o.xy[shuffled], o.sigma[shuffled])
        b = Block(noisy.block.cameras, noisy.block.images, noisy.block.points, mixed)
        a = adjust_block(b, ap_models.get("torlegard"))
        np.testing.assert_allclose(a.residuals, adjusted.residuals[shuffled], rtol=0.0, atol=1e-11)
        np.testing.assert_allclose(a.x, adjusted.x, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(a.std, adjusted.std, rtol=1e-9)


class TestCheckPoints:
    def checked(self, w: synthetic.World, shift_m: float) -> Block:
        """Every third tie point as a check point, its coordinates wrong by shift_m."""
        p = w.block.points
        chosen = (np.arange(len(p)) % 3 == 0) & (p.role == "tie")
        coordinates = np.where(chosen[:, None], w.coordinates + shift_m, p.coordinates)
        role = np.where(chosen, "check", p.role).tolist()
        sigma = np.where(chosen[:, None], 0.01, p.sigma)
        return w.with_points(role=role, coordinates=coordinates, sigma=sigma).block

    def test_their_coordinates_change_no_bit(self, noisy: synthetic.World) -> None:
        right = adjust_block(self.checked(noisy, 0.0), ap_models.get("torlegard"))
        wrong = adjust_block(self.checked(noisy, 100.0), ap_models.get("torlegard"))
        assert (right.block.points.role == "check").sum() > 20
        np.testing.assert_array_equal(right.x, wrong.x)
        np.testing.assert_array_equal(right.std, wrong.std)
        np.testing.assert_array_equal(right.points.values, wrong.points.values)
        assert right.sigma0 == wrong.sigma0
        assert right.observations == wrong.observations

    def test_they_are_tie_points(self, noisy: synthetic.World, adjusted: Adjustment) -> None:
        a = adjust_block(self.checked(noisy, 3.0), ap_models.get("torlegard"))
        np.testing.assert_allclose(a.points.values, adjusted.points.values, rtol=0.0, atol=1e-9)
        assert a.unknowns == adjusted.unknowns


class TestControl:
    MODEL = ap_models.get("optical")

    def with_sigma(self, noisy: synthetic.World, sigma_m: float) -> Adjustment:
        """All control alike, given with errors of 2 cm so that its weight matters."""
        w = noisy.controlled(synthetic.CONTROL, (sigma_m,) * 3)
        errors = 0.02 * np.random.default_rng(3).standard_normal((len(synthetic.CONTROL), 3))
        coordinates = w.block.points.coordinates.copy()
        coordinates[np.isin(w.block.points.ids, synthetic.CONTROL)] += errors
        a = adjust_block(w.with_points(coordinates=coordinates).block, self.MODEL)
        assert a.status.ok, a.message
        return a

    def test_fixed_control_keeps_exactly_its_coordinates(self, noisy: synthetic.World) -> None:
        shift = np.array([2_568_123.1, 5_641_987.7, 345.3])
        w = noisy.started_at(noisy.exterior + np.r_[shift, 0.0, 0.0, 0.0])
        b = w.with_points(coordinates=w.block.points.coordinates + shift).block
        a = adjust_block(b, self.MODEL)
        fixed = b.points.fixed
        assert fixed.sum() == 13
        np.testing.assert_array_equal(a.points.values[fixed], b.points.coordinates[fixed])
        np.testing.assert_array_equal(a.points.std[fixed], 0.0)
        assert (a.points.std[~fixed] > 0.0).all()

    def test_a_small_sigma_tends_to_fixed(self, noisy: synthetic.World) -> None:
        fixed, tight = self.with_sigma(noisy, 0.0), self.with_sigma(noisy, 1e-7)
        free = ~fixed.block.points.fixed
        # the control moves by its sigma times the strain of the block, which a sigma of 1e-7 m makes less than 1e-9 m
        np.testing.assert_allclose(tight.points.values, fixed.points.values, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose(tight.points.std[free], fixed.points.std[free], rtol=1e-6)
        np.testing.assert_allclose(tight.images.std, fixed.images.std, rtol=1e-6)
        assert tight.vpv == pytest.approx(fixed.vpv, rel=1e-6)
        assert tight.redundancy == fixed.redundancy

    def test_a_large_sigma_tends_to_unknown(self, noisy: synthetic.World) -> None:
        """Two of five control points lose their weight, and then their control."""
        ids, loose = ("11", "15", "51"), ("33", "55")

        def adjusted(sigma_m: float) -> Adjustment:
            p = noisy.block.points
            w = noisy.controlled(synthetic.CONTROL)
            sigma = np.where(np.isin(p.ids, loose)[:, None], sigma_m, w.block.points.sigma)
            a = adjust_block(w.with_points(sigma=sigma).block, self.MODEL)
            assert a.status.ok, a.message
            return a

        weightless, unknown = adjusted(1e5), adjusted(float("nan"))
        np.testing.assert_allclose(weightless.points.values, unknown.points.values, rtol=0.0, atol=1e-9)
        assert weightless.vpv == pytest.approx(unknown.vpv, rel=1e-9)
        # six observations that say nothing count nevertheless
        assert weightless.redundancy == unknown.redundancy + 6
        np.testing.assert_allclose(weightless.cofactors.diagonal, unknown.cofactors.diagonal, rtol=1e-9, atol=0.0)
        only = adjust_block(noisy.controlled(ids).block, self.MODEL)
        np.testing.assert_allclose(only.points.values, unknown.points.values, rtol=0.0, atol=1e-9)

    def test_weighted_control_pulls(self, noisy: synthetic.World) -> None:
        """Between fixed and free: the residual is the share of the error that the images do not believe."""
        a = self.with_sigma(noisy, 0.02)
        v = a.groups.control.residuals(a.x)
        assert len(v) == 15
        assert 0.002 < np.sqrt(np.mean(v**2)) < 0.03
        chosen = np.isin(a.points.ids, synthetic.CONTROL)
        assert (a.points.std[chosen] < 0.02 * a.sigma0).all()

    @pytest.mark.parametrize("axis", [0, 1, 2])
    def test_one_coordinate_less(self, noisy: synthetic.World, axis: int) -> None:
        """Each coordinate by itself: the one that is unknown is estimated, the others stand."""
        sigma = np.where(np.isin(noisy.block.points.ids, synthetic.CONTROL)[:, None], 0.0, [np.nan] * 3)
        at = noisy.block.points.ids.index("33")
        sigma[at, axis] = np.nan
        coordinates = noisy.block.points.coordinates.copy()
        coordinates[at, axis] = np.nan
        a = adjust_block(noisy.with_points(sigma=sigma, coordinates=coordinates).block, self.MODEL)
        assert a.status.ok, a.message
        others = np.arange(3) != axis
        np.testing.assert_array_equal(a.points.values[at, others], noisy.coordinates[at, others])
        assert a.points.std[at, axis] > 0.0
        assert abs(a.points.values[at, axis] - noisy.coordinates[at, axis]) < 4.0 * a.points.std[at, axis]
