"""Observed stations and prior values of parameters: in both arithmetics, against the full matrices, and in
simulation.
"""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Adjustment, Status, adjust_block, ap_models
from adjust.datum import InnerConstraints
from adjust.normals.normals import Plain
from adjust.observations.ap_priors import ApPriors
from adjust.observations.group import Group
from adjust.observations.stations import StationAttitudes, StationPositions
from adjust.quality.gross_errors import snoop
from adjust.quality.reliability import Reliability
from adjust.quality.variance import groups_by_camera, variance_components
from adjust.solution.iteration import ERROR_LEFT
from tests import synthetic
from tests.adjust import dense

MODEL = ap_models.get("torlegard")
STRIPS = tuple("111222333444")
OFFSET, DRIFT = np.array([0.8, -0.5, 1.2]), np.array([0.1, 0.2, -0.3])


def positions(
    w: synthetic.World, rng: np.random.Generator, sigma_m: float = 0.05, unknown: bool = True, biased: bool = True
) -> StationPositions:
    """GNSS positions of all images with an offset and a drift, the same in every strip."""
    t = np.tile([-1.0, 0.0, 1.0], 4)[:, None]
    true = w.exterior[:, :3]
    observed = true - biased * (OFFSET + DRIFT * t) + sigma_m * rng.standard_normal(true.shape)
    sigma = np.full(true.shape, sigma_m)
    return StationPositions(w.block.images.ids, observed, sigma, STRIPS, offset=unknown, drift=unknown)


def attitudes(w: synthetic.World, rng: np.random.Generator, sigma_rad: float = 1e-4) -> StationAttitudes:
    true = w.exterior[:, 3:]
    observed = true + sigma_rad * rng.standard_normal(true.shape)
    observed[3, 1] = np.nan
    observed[:, 2] += 2.0 * np.pi * (np.arange(12) % 2)
    return StationAttitudes(w.block.images.ids, observed, np.full(true.shape, sigma_rad))


@pytest.fixture(scope="module")
def w(ww_world: synthetic.World) -> synthetic.World:
    return ww_world.with_noise(np.random.default_rng(5)).controlled(synthetic.CONTROL, (0.02, 0.02, 0.02))


@pytest.fixture(scope="module")
def groups(w: synthetic.World) -> tuple[Group, ...]:
    rng = np.random.default_rng(6)
    priors = ApPriors("ww", {"a1": (0.0, 1e-5), "a3": (0.0, 1e-9)})
    return positions(w, rng), attitudes(w, rng), priors


@pytest.fixture(scope="module")
def a(w: synthetic.World, groups: tuple[Group, ...]) -> Adjustment:
    return adjust_block(w.block, MODEL, observations=groups)


def test_both_arithmetics_and_the_full_matrices(w: synthetic.World, groups: tuple[Group, ...], a: Adjustment) -> None:
    assert a.status.ok, a.message
    plain = adjust_block(w.block, MODEL, observations=groups, compiled=False)
    np.testing.assert_allclose((a.x - plain.x)[a.layout.free] / a.std[a.layout.free], 0.0, atol=2.0 * ERROR_LEFT)
    full = dense.solve(a.groups, a.x)
    std = np.sqrt(np.diag(full.inverse)[a.layout.free])
    np.testing.assert_allclose(full.step[a.layout.free] / std, 0.0, atol=ERROR_LEFT)
    everything = np.flatnonzero(a.layout.free)
    for each in (a, plain):
        q = each.cofactors.block(everything, everything) / std / std[:, None]
        expected = full.inverse[np.ix_(everything, everything)] / std / std[:, None]
        np.testing.assert_allclose(q, expected, rtol=0.0, atol=dense.SAME)
    normals = Plain(a.groups).at(a.x)
    assert normals.vpv == pytest.approx(a.vpv, rel=1e-12)
    assert a.arithmetic.at(a.x).vpv == pytest.approx(a.vpv, rel=1e-12)


def test_counts_and_names(w: synthetic.World, a: Adjustment) -> None:
    assert a.observations == 2 * len(w.block.observations) + 15 + 36 + 35 + 2
    assert a.unknowns == 6 * 12 + 6 + 24 + 3 * len(w.block.points)
    assert a.redundancy == a.observations - a.unknowns
    at = a.layout.index("position of strip 2", "drift Z0")
    assert a.layout.name(at) == "drift Z0 of position of strip 2"
    assert list(groups_by_camera(a)) == ["images of ww", "control", "positions", "attitudes", "priors of ww"]


def test_reliability(a: Adjustment) -> None:
    found = Reliability.of(a)
    assert found.redundancy.sum() == pytest.approx(a.redundancy, abs=len(found) * dense.SAME)
    design, v, weight = dense.in_block_order(a)
    hat, _ = dense.factors(np.sqrt(weight)[:, None] * design[:, a.layout.free])
    r = 1.0 - np.sum(hat**2, axis=1)
    np.testing.assert_allclose(found.redundancy, r, rtol=0.0, atol=dense.SAME)
    np.testing.assert_allclose(found.w, np.sqrt(weight / r) * v, rtol=0.0, atol=dense.SAME)
    k2 = found.image_points.stop
    assert found.name(k2 + 15) == "X0 of image ww-1"
    assert found.name(len(found) - 1) == "prior of a3 of camera ww"


def test_offset_and_drift_are_found(w: synthetic.World, a: Adjustment) -> None:
    for strip in "1234":
        for kind, true in (("offset", OFFSET), ("drift", DRIFT)):
            for axis, name in enumerate(("X0", "Y0", "Z0")):
                at = a.layout.index(f"position of strip {strip}", f"{kind} {name}")
                assert abs(a.x[at] + true[axis]) < 4.5 * a.std[at]


def test_stations_instead_of_control(ww_world: synthetic.World) -> None:
    nothing = np.full_like(ww_world.coordinates, np.nan)
    free = ww_world.with_points(role=["tie"] * len(nothing), coordinates=nothing, sigma=nothing)
    free = free.with_noise(np.random.default_rng(2))
    gnss = positions(free, np.random.default_rng(3), unknown=False, biased=False)
    a = adjust_block(free.block, MODEL, observations=[gnss])
    assert a.status.ok, a.message
    error = (a.points.values - ww_world.coordinates) / a.points.std
    assert np.sqrt(np.mean(error**2)) < 2.0


def test_a_datum_that_offsets_take_away(ww_world: synthetic.World) -> None:
    """With an offset and a drift in every strip, positions alone do not say where the block is."""
    nothing = np.full_like(ww_world.coordinates, np.nan)
    free = ww_world.with_points(role=["tie"] * len(nothing), coordinates=nothing, sigma=nothing)
    a = adjust_block(free.block, observations=[positions(free, np.random.default_rng(3))])
    assert a.status is Status.SINGULAR
    assert "cannot be separated" in a.message


class TestPriors:
    def test_a_tight_one_holds(self, w: synthetic.World) -> None:
        a = adjust_block(w.block, MODEL, observations=[ApPriors("ww", {"a3": (2e-9, 1e-16)})])
        assert a.ap["ww"]["a3"] == pytest.approx(2e-9, rel=1e-5)

    def test_a_loose_one_changes_nothing(self, w: synthetic.World) -> None:
        free, loose = (adjust_block(w.block, MODEL, observations=o) for o in ((), [ApPriors("ww", {"a3": (0.0, 1.0)})]))
        np.testing.assert_allclose(loose.ap["ww"].values, free.ap["ww"].values, rtol=1e-9)
        assert loose.redundancy == free.redundancy + 1

    def test_they_cure_what_cannot_be_separated(self, vertical_world: synthetic.World) -> None:
        """Gruen's 44 parameters on a flat vertical block: some are orientations under another name."""
        model = ap_models.get("gruen44")
        free = adjust_block(vertical_world.block, model)
        priors = ApPriors("ww", dict.fromkeys(model.parameters, (0.0, 1e-6)))
        a = adjust_block(vertical_world.block, model, observations=[priors])
        assert a.status.ok, a.message
        assert a.observations == 2 * len(vertical_world.block.observations) + 44
        if free.status.ok:
            assert (a.ap["ww"].std / a.sigma0 <= free.ap["ww"].std / free.sigma0 * (1 + 1e-9)).all()


def test_a_wrong_position_is_found(w: synthetic.World) -> None:
    gnss = positions(w, np.random.default_rng(6), unknown=False, biased=False)
    gnss.values[4, 2] += 1.5
    found = snoop(adjust_block(w.block, MODEL, observations=[gnss]), 1e-5)
    assert [each.name for each in found.accused] == ["Z0 of image ww-5"]
    assert found.accused[0].error == pytest.approx(1.5, abs=0.4)


def test_their_own_variance(w: synthetic.World) -> None:
    gnss = positions(w, np.random.default_rng(7), sigma_m=0.10, unknown=False, biased=False)
    stated = StationPositions(gnss.image_ids, gnss.values, np.full_like(gnss.sigma, 0.05))
    found = variance_components(adjust_block(w.block, MODEL, observations=[stated]))
    at = found.names.index("positions")
    assert abs(found.sigma_factor[at] - 2.0) < 4.0 * found.sigma_factor_std[at]
    assert found.converged


class TestRefusals:
    def test_unknown_image(self, w: synthetic.World) -> None:
        with pytest.raises(ValueError, match="position of image 'x': there is no such image"):
            adjust_block(w.block, observations=[StationPositions(("x",), np.zeros((1, 3)), np.ones((1, 3)))])

    def test_shapes_and_sigmas(self, w: synthetic.World) -> None:
        image = w.block.images.ids[:1]
        with pytest.raises(ValueError, match=r"shape \(1, 3\)"):
            adjust_block(w.block, observations=[StationPositions(image, np.zeros((2, 3)), np.ones((2, 3)))])
        with pytest.raises(ValueError, match="standard deviation > 0"):
            adjust_block(w.block, observations=[StationAttitudes(image, np.zeros((1, 3)), np.zeros((1, 3)))])

    def test_twice_the_same_unknowns(self, w: synthetic.World) -> None:
        gnss = positions(w, np.random.default_rng(1))
        with pytest.raises(ValueError, match="two groups of observations have an unknown offset X0"):
            adjust_block(w.block, observations=[gnss, gnss])

    def test_priors(self, w: synthetic.World) -> None:
        with pytest.raises(KeyError, match="no unknown 'b1' of 'ww'"):
            adjust_block(w.block, MODEL, observations=[ApPriors("ww", {"b1": (0.0, 1.0)})])
        with pytest.raises(ValueError, match="prior of a1 of camera ww: 0 \\+- 0 is not allowed"):
            adjust_block(w.block, MODEL, observations=[ApPriors("ww", {"a1": (0.0, 0.0)})])

    def test_a_free_network(self, w: synthetic.World) -> None:
        gnss = positions(w, np.random.default_rng(1))
        a = adjust_block(w.block, MODEL, datum=InnerConstraints(), observations=[gnss])
        assert a.status is Status.NO_START
        assert "a free network cannot hold observed stations" in a.message
        priors = ApPriors("ww", {"a1": (0.0, 1e-5)})
        free = adjust_block(w.block, MODEL, datum=InnerConstraints(), observations=[priors])
        assert free.status.ok, free.message
        assert free.observations == 2 * len(w.block.observations) + 1
