"""The eliminated normal equations against the full ones, on everything they answer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adjust import Status, adjust_block, ap_models
from adjust.model.unknowns import Unknowns
from adjust.normals.band import BandFactor
from adjust.normals.cofactors import Cofactors
from adjust.normals.normals import Plain
from adjust.normals.normals_compiled import Compiled
from adjust.observations.observations import Observations
from adjust.solution import initial
from adjust.solution.iteration import ERROR_LEFT
from simfield.block.block import Block, ImageObservations, Images
from tests import synthetic
from tests.adjust import dense

# The scaled normal equations of these blocks have condition numbers up to 1e5, so either way of solving them is
# good to about 1e-11; differences are relative to the standard deviations concerned.
RELATIVE_TOLERANCE = 1e-10

NAN = float("nan")
CONTROL = {
    "fixed": [(synthetic.CONTROL, (0.0, 0.0, 0.0))],
    "weighted": [(synthetic.CONTROL, (0.02, 0.01, 0.03))],
    "fixed in plan, weighted in height": [(synthetic.CONTROL, (0.0, 0.0, 0.05))],
    "partial": [
        (("11", "55"), (0.0, 0.0, 0.0)),
        (("15", "16"), (NAN, NAN, 0.0)),
        (("33", "49"), (NAN, NAN, 0.02)),
        (("51",), (0.01, 0.0, NAN)),
    ],
}


def controlled(world: synthetic.World, control: str) -> synthetic.World:
    """Several kinds of control in one world."""
    p = world.block.points
    role, sigma = np.full(len(p), "tie", dtype="<U7"), np.full((len(p), 3), np.nan)
    for ids, sigmas in CONTROL[control]:
        chosen = np.isin(p.ids, ids)
        role[chosen] = "control"
        sigma[chosen] = sigmas
    coordinates = np.where(np.isfinite(sigma), world.coordinates, np.nan)
    return world.with_points(role=role.tolist(), coordinates=coordinates, sigma=sigma)


@pytest.mark.parametrize("control", CONTROL)
@pytest.mark.parametrize("model", ["none", "optical", "torlegard", "brown14"])
@pytest.mark.parametrize("cameras", [1, 2])
@pytest.mark.parametrize("arithmetic", [Plain, Compiled])
def test_step_and_cofactors(
    ww_world: synthetic.World,
    two_camera_world: synthetic.World,
    arithmetic: type[Plain] | type[Compiled],
    cameras: int,
    model: str,
    control: str,
) -> None:
    w = controlled(ww_world if cameras == 1 else two_camera_world, control).with_noise(np.random.default_rng(2))
    unknowns = Unknowns.of(w.block, ap_models.get(model))
    observations = Observations.of(w.block, unknowns)
    x = initial.values(unknowns, observations.image_points)
    full = dense.solve(observations, x)
    normals = arithmetic(observations).at(x)
    factor = arithmetic(observations).factorise(normals)

    std = np.sqrt(np.diag(full.inverse))
    step, length = factor.step(normals)
    held = ~unknowns.free
    np.testing.assert_array_equal(step[held], 0.0)
    assert (np.abs(step - full.step) <= RELATIVE_TOLERANCE * length * std).all()
    expected_length = float(np.sqrt(-full.step @ _gradient(observations, x)))
    assert length == pytest.approx(expected_length, rel=RELATIVE_TOLERANCE)

    cofactors = Cofactors(unknowns, factor)
    everything = np.arange(len(x))
    difference = np.abs(cofactors.block(everything, everything) - full.inverse)
    assert (difference <= RELATIVE_TOLERANCE * std * std[:, None]).all()
    np.testing.assert_allclose(np.sqrt(cofactors.diagonal), std, rtol=RELATIVE_TOLERANCE)
    np.testing.assert_array_equal(cofactors.diagonal[held], 0.0)


def _gradient(observations: Observations, x: np.ndarray) -> np.ndarray:
    a, v, weight = dense.design(observations, x)
    return np.asarray(a.T @ (weight * v))


def test_vpv_and_standard_deviations_of_an_adjustment(two_camera_world: synthetic.World) -> None:
    w = controlled(two_camera_world, "partial").with_noise(np.random.default_rng(3))
    a = adjust_block(w.block, ap_models.get("torlegard"))
    assert a.status.ok, a.message
    _, v, weight = dense.design(a.groups, a.x)
    assert a.observations == len(v)
    assert a.unknowns == int(a.layout.free.sum())
    sigma0 = np.sqrt(np.sum(weight * v**2) / (len(v) - a.unknowns))
    assert a.sigma0 == pytest.approx(sigma0, rel=1e-12)
    std = sigma0 * np.sqrt(np.diag(dense.solve(a.groups, a.x).inverse))
    np.testing.assert_allclose(a.std, std, rtol=dense.SAME)
    # what a full step would still change
    step = dense.solve(a.groups, a.x).step[a.layout.free] / std[a.layout.free]
    assert np.abs(step).max() < ERROR_LEFT


def test_mixed_models(two_camera_world: synthetic.World) -> None:
    """Sets of different width in one adjustment, one camera without any."""
    w = two_camera_world.with_noise(np.random.default_rng(4))
    models = {"ww": ap_models.get("brown14"), "sww": ap_models.get("none")}
    a = adjust_block(w.block, models)
    assert a.status.ok, a.message
    assert a.ap["sww"].names == ()
    assert len(a.ap["ww"].values) == 14
    std = a.sigma0 * np.sqrt(np.diag(dense.solve(a.groups, a.x).inverse))
    np.testing.assert_allclose(a.std, std, rtol=dense.SAME)
    with pytest.raises(KeyError, match="sww"):
        adjust_block(w.block, {"ww": ap_models.get("optical")})


class TestBand:
    """A long strip, in which few images share points: its normal equations are a band, whatever the size."""

    @pytest.fixture
    def strip(self, monkeypatch: pytest.MonkeyPatch) -> synthetic.World:
        monkeypatch.setattr(Compiled, "banded", True)
        rng = np.random.default_rng(0)
        field = {f"{i}/{j}": [400.0 * i, 400.0 * j, rng.uniform(-40.0, 40.0)] for i in range(36) for j in range(-2, 3)}
        stations = [[966.0 * i, 0.0, 1605.0, *rng.normal(0.0, 0.01, 3)] for i in range(14)]
        control = ("0/2", "0/-2", "16/0", "30/2", "30/-2")
        w = synthetic.world([(synthetic.WW, np.array(stations))], field, control=control)
        order = rng.permutation(len(w.block.images))  # the images come in no order
        place = np.argsort(order)
        b, o = w.block, w.block.observations
        images = Images(tuple(b.images.ids[i] for i in order), b.images.camera, b.images.exterior[order])
        observations = ImageObservations(place[o.image], o.point, o.xy, o.sigma)
        shuffled = Block(b.cameras, images, b.points, observations)
        return replace(w, block=shuffled, exterior=w.exterior[order]).with_noise(rng)

    @pytest.mark.parametrize("model", ["none", "brown14"])
    def test_step_and_cofactors(self, strip: synthetic.World, model: str) -> None:
        unknowns = Unknowns.of(strip.block, ap_models.get(model))
        observations = Observations.of(strip.block, unknowns)
        x = initial.values(unknowns, observations.image_points)
        compiled = Compiled(observations)
        factor = compiled.factorise(compiled.at(x))
        assert isinstance(factor, BandFactor)
        full = dense.solve(observations, x)
        std = np.sqrt(np.diag(full.inverse))
        step, length = factor.step(compiled.at(x))
        assert (np.abs(step - full.step) <= RELATIVE_TOLERANCE * length * std).all()
        cofactors = Cofactors(unknowns, factor)
        everything = np.arange(len(x))
        difference = np.abs(cofactors.block(everything, everything) - full.inverse)
        assert (difference <= RELATIVE_TOLERANCE * std * std[:, None]).all()
        np.testing.assert_allclose(np.sqrt(cofactors.diagonal), std, rtol=RELATIVE_TOLERANCE)

    @pytest.mark.parametrize("model", ["none", "brown14"])
    def test_estimates(self, strip: synthetic.World, model: str) -> None:
        a = adjust_block(strip.block, ap_models.get(model))
        plain = adjust_block(strip.block, ap_models.get(model), compiled=False)
        assert a.status.ok, a.message
        assert (np.abs(a.x - plain.x) <= 1e-8 * plain.std + 1e-12).all()

    @pytest.mark.parametrize("ids", [(), ("16/0",), ("0/2", "30/-2")])
    def test_it_explains_itself_as_any_other(self, strip: synthetic.World, ids: tuple[str, ...]) -> None:
        w = strip.controlled(ids)
        a, plain = (adjust_block(w.block, ap_models.get("optical"), compiled=c) for c in (True, False))
        assert a.status is Status.SINGULAR
        assert a.message == plain.message
