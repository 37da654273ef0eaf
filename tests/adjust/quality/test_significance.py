"""Tests of additional parameters against what adjusting with and without them says."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats

from adjust import Adjustment, adjust_block, ap_models
from adjust.ap_models.restricted import Restricted, without
from adjust.observations import ApPriors
from adjust.quality.model_choice import _OwnSets, aic, bic, delete_stepwise, leave_one_image_out
from adjust.quality.significance import ap_significance, f_test, global_test
from adjust.trials.traced_terms import Trace
from simfield.block.block import Block, Points
from tests import synthetic
from tests.adjust import dense

MODEL = ap_models.get("torlegard")
AP = {"ww": np.array([8e-5, 0.0, -1.8e-8, 5e-13, 0.0, 0.0])}


@pytest.fixture(scope="module")
def w() -> synthetic.World:
    flight = [(synthetic.WW, synthetic.fly(synthetic.WW, 10500.0))]
    world = synthetic.world(flight, synthetic.quincunx(per_group=2), {"ww": MODEL}, AP)
    return world.with_noise(np.random.default_rng(8))


@pytest.fixture(scope="module")
def a(w: synthetic.World) -> Adjustment:
    return adjust_block(w.block, MODEL)


class TestRestricted:
    def test_terms_and_names(self) -> None:
        part = Restricted(MODEL, ("a4", "a1"))
        x, y = np.array([10.0, -80.0]), np.array([5.0, 60.0])
        at = [MODEL.parameters.index(name) for name in ("a1", "a4")]
        assert part.parameters == ("a1", "a4")
        np.testing.assert_array_equal(part.basis(x, y), MODEL.basis(x, y)[:, :, at])
        assert without(without(MODEL, "a2"), "a3").parameters == ("a1", "a4", "a5", "a6")
        assert without(without(MODEL, "a2"), "a3").model is MODEL

    def test_it_can_be_compiled(self) -> None:
        assert len(Trace.of(Restricted(MODEL, ("a3",))).parts) == 1

    def test_of_a_set_that_is_not_linear(self) -> None:
        """Parameters that are left out are 0, and only the others have derivatives."""
        whole = ap_models.get("brown1971")
        part = without(whole, *whole.parameters[1::2])
        x, y = np.array([10.0, -80.0]), np.array([5.0, 60.0])
        values = 1e-5 * np.arange(1.0, 1.0 + len(part.parameters))
        padded = np.zeros(len(whole.parameters))
        padded[::2] = values
        d, derivatives = whole.evaluate(x, y, padded)
        found, by_kept = part.evaluate(x, y, values)
        np.testing.assert_array_equal(found, d)
        np.testing.assert_array_equal(by_kept, derivatives[:, :, ::2])
        assert part.linear == whole.linear
        assert part.principal_distance in ("", whole.principal_distance)
        assert set(part.why_not_estimable) <= set(part.parameters)

    def test_unknown_names(self) -> None:
        with pytest.raises(ValueError, match="torlegard has no parameter 'b1', it has: a1"):
            Restricted(MODEL, ("b1",))
        with pytest.raises(ValueError, match="has no parameter 'a2'"):
            without(without(MODEL, "a2"), "a2")


def vpv_without(w: synthetic.World, *names: str) -> float:
    return adjust_block(w.block, without(MODEL, *names)).vpv


def test_t_is_the_rise_of_vpv(w: synthetic.World, a: Adjustment) -> None:
    found = ap_significance(a, "ww")
    for name, t in zip(found.names, found.t, strict=True):
        rise = (vpv_without(w, name) - a.vpv) / a.sigma0**2
        assert t**2 == pytest.approx(rise, rel=2e-3, abs=1e-4)
    np.testing.assert_allclose(found.p, 2 * scipy.stats.t.sf(np.abs(found.t), a.redundancy), rtol=1e-9)


def test_z_is_the_fall_of_vpv_one_after_the_other(w: synthetic.World, a: Adjustment) -> None:
    found = ap_significance(a, "ww")
    steps = [adjust_block(w.block, Restricted(MODEL, found.names[:k])).vpv for k in range(len(found.names) + 1)]
    np.testing.assert_allclose(found.z**2 * a.sigma0**2, -np.diff(steps), rtol=5e-3, atol=1e-3)
    assert found.z[-1] == pytest.approx(found.t[-1], rel=1e-9)


def test_a_group(w: synthetic.World, a: Adjustment) -> None:
    found = f_test(a, ("ww", "a2"), ("ww", "a5"), ("ww", "a6"))
    rise = vpv_without(w, "a2", "a5", "a6") - a.vpv
    assert found.statistic == pytest.approx(rise / 3 / a.sigma0**2, rel=2e-3)
    assert found.p == pytest.approx(scipy.stats.f.sf(found.statistic, 3, a.redundancy), rel=1e-9)
    one = f_test(a, ("ww", "a2"))
    assert one.statistic == pytest.approx(ap_significance(a, "ww").t[1] ** 2, rel=1e-9)
    everything = f_test(a, *(("ww", name) for name in MODEL.parameters))
    assert everything.statistic == pytest.approx(np.mean(ap_significance(a, "ww").z ** 2), rel=1e-8)


def test_multiple_correlations_are_the_textbook(a: Adjustment) -> None:
    q = dense.solve(a.groups, a.x).inverse[: a.layout.orientation, : a.layout.orientation]
    images = 6 * len(a.block.images)
    found = ap_significance(a, "ww")
    inverse = np.linalg.inv(q)
    for j in range(len(found.names)):
        at = images + j
        rho = q[at, :images] @ np.linalg.inv(q[:images, :images]) @ q[:images, at] / q[at, at]
        assert found.with_exterior[j] == pytest.approx(np.sqrt(rho), abs=dense.SAME)
        assert found.with_all[j] == pytest.approx(np.sqrt(1.0 - 1.0 / (q[at, at] * inverse[at, at])), abs=dense.SAME)
        owner, name, r = found.strongest[j]
        assert a.correlation(("ww", found.names[j]), (owner, name))[0, 1] == pytest.approx(r, abs=dense.SAME)


def test_a_camera_without_parameters(w: synthetic.World) -> None:
    assert ap_significance(adjust_block(w.block), "ww").names == ()


def test_the_global_test(a: Adjustment) -> None:
    found = global_test(a, 0.05)
    assert found.passed
    assert found.lower == pytest.approx(scipy.stats.chi2.ppf(0.025, a.redundancy), rel=1e-9)
    assert found.upper == pytest.approx(scipy.stats.chi2.isf(0.025, a.redundancy), rel=1e-9)
    assert 0.0 < found.p <= 1.0
    o = a.block.observations
    optimistic = Block(a.block.cameras, a.block.images, a.block.points, type(o)(o.image, o.point, o.xy, o.sigma / 1.3))
    assert not global_test(adjust_block(optimistic, MODEL)).passed


class TestChoice:
    def test_criteria_prefer_the_right_set(self, w: synthetic.World, a: Adjustment) -> None:
        none, many = adjust_block(w.block), adjust_block(w.block, ap_models.get("gruen44"))
        needed = adjust_block(w.block, Restricted(MODEL, ("a1", "a3", "a4")))
        for criterion in (aic, bic, lambda each: leave_one_image_out(each).rms_um):
            assert criterion(needed) < criterion(none)
            assert criterion(needed) < criterion(many)
        n = a.observations
        assert aic(a) == pytest.approx(n * np.log(a.vpv / n) + 2 * a.unknowns, rel=1e-12)
        assert bic(a) - aic(a) == pytest.approx(a.unknowns * (np.log(n) - 2.0), rel=1e-9)

    def test_stepwise_deletion_leaves_what_is_there(self, a: Adjustment) -> None:
        found = delete_stepwise(a, alpha=0.01)
        assert [d.name for d in found.deleted] == ["a6", "a5", "a2"] or {d.name for d in found.deleted} == {
            "a2",
            "a5",
            "a6",
        }
        assert found.adjustment.ap["ww"].names == ("a1", "a3", "a4")
        assert all("not significant" in d.reason for d in found.deleted)
        assert (ap_significance(found.adjustment, "ww").p <= 0.01).all()

    def test_what_orientation_can_do_goes_first(self) -> None:
        """In a nearly flat, nearly vertical block a shift of the image is a shift of the station."""
        flight = [(synthetic.WW, synthetic.fly(synthetic.WW, 10500.0, headings=(0.0, 0.0), tilt_rad=0.002))]
        flat = synthetic.world(flight, synthetic.quincunx(relief_m=20.0, per_group=2)).with_noise(
            np.random.default_rng(4)
        )
        flat = flat.controlled(flat.block.points.ids, (0.02, 0.02, 0.02))
        adjusted = adjust_block(flat.block, ap_models.get("ebner12"))
        if adjusted.status.ok:
            first = delete_stepwise(adjusted, correlation_most=0.99).deleted[0]
            assert first.with_exterior > 0.5

    def test_one_set_for_all_predicts_best_where_it_is_true(self, ww_world: synthetic.World) -> None:
        """Sets for each image take up more of the image that is left out, and once won for that."""
        for seed in range(8):
            block = ww_world.with_noise(np.random.default_rng(seed)).block
            by = {c: leave_one_image_out(adjust_block(block, MODEL, ap_by=c)) for c in ("camera", "image")}
            assert by["camera"].rms_um < by["image"].rms_um < 1.2 * by["camera"].rms_um
            assert by["image"].count.sum() > 0.97 * by["camera"].count.sum()

    def test_the_set_of_an_image_is_predicted_by_those_of_the_others(self, ww_world: synthetic.World) -> None:
        """Against holding it there by prior values, by which the other sets, too, move a little."""
        block, image = ww_world.with_noise(np.random.default_rng(2)).block, 4
        name = block.images.ids[image]
        a = adjust_block(block, MODEL, ap_by="image")
        own, mean = _OwnSets(a).of(image)
        np.testing.assert_array_equal(own, [a.layout.index(name, p) for p in MODEL.parameters])
        std = a.ap[name].std
        priors = {p: (float(m), 1e-3 * float(s)) for p, m, s in zip(MODEL.parameters, mean, std, strict=True)}
        held = adjust_block(block, MODEL, ap_by="image", observations=[ApPriors(name, priors)])
        found, expected = leave_one_image_out(a), leave_one_image_out(held)
        assert found.count[image] == expected.count[image]
        assert found.squares[image] == pytest.approx(expected.squares[image], rel=0.02)

    def test_prediction_is_what_resection_leaves(self, w: synthetic.World, a: Adjustment) -> None:
        """Against doing it: adjust without an image, then orient the image by the points and parameters found."""
        image = 4
        o = w.block.observations
        mine = o.image == image
        kept = type(o)(o.image[~mine] - (o.image[~mine] > image), o.point[~mine], o.xy[~mine], o.sigma[~mine])
        rows = [i for i in range(len(w.block.images)) if i != image]
        images = type(w.block.images)(
            tuple(w.block.images.ids[i] for i in rows), w.block.images.camera[rows], w.block.images.exterior[rows]
        )
        others = adjust_block(Block(w.block.cameras, images, w.block.points, kept), MODEL)
        assert others.status.ok, others.message
        distortion = MODEL.basis(*o.xy[mine].T) @ others.ap["ww"].values
        points = Points(
            w.block.points.ids,
            np.full(len(others.coordinates), "control"),
            others.coordinates,
            np.zeros_like(others.coordinates),
        )
        single = type(w.block.images)((w.block.images.ids[image],), np.array([0]), w.block.images.exterior[[image]])
        seen = type(o)(np.zeros(mine.sum(), dtype=int), o.point[mine], o.xy[mine] - distortion, o.sigma[mine])
        resected = adjust_block(Block(w.block.cameras, single, points, seen))
        assert resected.status.ok, resected.message
        found = leave_one_image_out(a)
        assert found.count[image] <= 2 * mine.sum() - 6
        assert found.squares[image] > 0.0
        # the pseudo-inverse weights the prediction by its precision, resection by that of the measurement alone
        simple = np.sum((resected.residuals / synthetic.SIGMA_MM) ** 2)
        assert found.squares[image] == pytest.approx(simple, rel=0.1)
        assert np.isfinite(found.by_image_um).all()
        assert 3.0 < found.rms_um < 6.0
