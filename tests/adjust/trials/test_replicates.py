"""Many trials at once against one trial at a time: the same minimiser, whatever the route."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from adjust import ApModel, Status, adjust_block, ap_models
from adjust.trials.replicates import Replicates, adjust_prepared, adjust_replicates, prepared
from simfield import build_world, presets
from simfield.block.block import Block, Floats, Points
from simfield.numerics.arena import Arena
from tests import synthetic

SAME_MINIMUM = 1e-8
"""standard deviations; what adjust_replicates promises for every unknown"""
STD_NOMINAL = 1e-3
"""relative; nominal cofactors against those of the trial, 2e-4 at 4 um of noise"""
TRIALS = 5
LINEAR = [name for name in ap_models.names() if ap_models.get(name).linear]


def noisy(block: Block, trials: int, seed: int = 1) -> Floats:
    errors = np.random.default_rng(seed).normal(size=(trials, len(block.observations), 2))
    return np.asarray(block.observations.xy + errors * block.observations.sigma)


def largest_difference(r: Replicates, trial: int, block: Block, model: Any) -> float:
    """Between a trial and adjust_block, in standard deviations for sigma0 = 1, over all unknowns."""
    a = adjust_block(block, model)
    assert a.status.ok
    # the layouts agree, but each reduces coordinates to an origin of its own
    shift = np.zeros_like(a.x)
    images = 6 * len(block.images)
    difference = (r.nominal.layout.origin - a.layout.origin)[None]
    shift[:images].reshape(-1, 6)[:, :3] = difference
    shift[a.layout.orientation :].reshape(-1, 3)[:] = difference
    s = np.sqrt(a.cofactors.diagonal)
    moved = np.abs(r.trials.x[trial] + shift - a.x)
    assert np.all(moved[s == 0.0] < 1e-9)
    return float((moved[s > 0.0] / s[s > 0.0]).max())


def weighted(block: Block, sigma_m: float) -> Block:
    p = block.points
    sigma = np.where(p.role[:, None] == "control", sigma_m, p.sigma)
    return Block(block.cameras, block.images, Points(p.ids, p.role, p.coordinates, sigma), block.observations)


class TestSameMinimum:
    @pytest.mark.parametrize("name", LINEAR)
    def test_every_model(self, two_camera_world: synthetic.World, name: str) -> None:
        model = ap_models.get(name)
        model = ap_models.get(name, without=model.not_estimable) if hasattr(model, "without") else model
        block = two_camera_world.with_noise(np.random.default_rng(0)).block
        if not adjust_block(block, model).status.ok:
            with pytest.raises(ValueError, match="no nominal adjustment"):
                adjust_replicates(block, model, noisy(block, 1))
            return
        xy = noisy(block, TRIALS)
        r = adjust_replicates(block, model, xy)
        assert r.ok.all()
        for trial in range(TRIALS):
            assert largest_difference(r, trial, block.replace_image_points(xy[trial]), model) < SAME_MINIMUM

    def test_a_model_for_each_camera(self, two_camera_world: synthetic.World) -> None:
        models: Mapping[str, ApModel] = {"ww": ap_models.get("brown14"), "sww": ap_models.get("optical")}
        block = two_camera_world.block
        xy = noisy(block, TRIALS)
        r = adjust_replicates(block, models, xy)
        assert largest_difference(r, 2, block.replace_image_points(xy[2]), models) < SAME_MINIMUM
        assert r.ap("ww").shape == (TRIALS, 14)
        assert r.ap("sww").shape == (TRIALS, 4)

    def test_weighted_control_that_is_disturbed(self, two_camera_world: synthetic.World) -> None:
        block = weighted(two_camera_world.block, 0.03)
        model = ap_models.get("optical")
        xy = noisy(block, TRIALS)
        errors = np.random.default_rng(5).normal(0.0, 0.03, (TRIALS, len(block.points), 3))
        given = block.points.coordinates + errors
        r = adjust_replicates(block, model, xy, coordinates=given)
        for trial in range(TRIALS):
            p = block.points
            of_trial = Block(
                block.cameras,
                block.images,
                Points(p.ids, p.role, given[trial], p.sigma),
                block.replace_image_points(xy[trial]).observations,
            )
            assert largest_difference(r, trial, of_trial, model) < SAME_MINIMUM

    def test_fixed_control_takes_the_coordinates_of_the_trial(self, ww_world: synthetic.World) -> None:
        block = ww_world.block
        given = np.repeat(block.points.coordinates[None], 2, axis=0)
        given[1, block.points.role == "control"] += 0.01
        r = adjust_replicates(block, None, noisy(block, 2), coordinates=given)
        fixed = block.points.fixed
        np.testing.assert_allclose(r.points[1][fixed], given[1][fixed], rtol=0.0, atol=1e-12)

    @pytest.mark.parametrize("size_um", [100.0, 3000.0])
    def test_gross_errors_are_never_wrong(self, ww_world: synthetic.World, size_um: float) -> None:
        block, model = ww_world.block, ap_models.get("brown14")
        xy = noisy(block, 40)
        for trial in (3, 17, 33):
            xy[trial, 10 * trial % len(block.observations)] += size_um / 1000.0
        r = adjust_replicates(block, model, xy)
        assert r.ok.all()
        for trial in (3, 17, 33, 34):
            assert largest_difference(r, trial, block.replace_image_points(xy[trial]), model) < SAME_MINIMUM

    def test_flights_that_are_flown_anew(self) -> None:
        """Other positions and attitudes in every trial, of the same points in the same images."""
        stations = synthetic.fly(synthetic.WW, 10500.0)
        field = synthetic.quincunx()
        first = synthetic.world([(synthetic.WW, stations)], field)
        rng = np.random.default_rng(8)
        moves = rng.normal(size=(3, *stations.shape)) * [5.0, 5.0, 5.0, 2e-3, 2e-3, 2e-3]
        flown = [synthetic.world([(synthetic.WW, stations + move)], field).block for move in moves]
        pairs = set.intersection(*({*map(tuple, names(b))} for b in [first.block, *flown]))
        blocks = [only(b, pairs) for b in [first.block, *flown]]
        xy = np.stack([b.observations.xy for b in blocks[1:]]) + noisy(blocks[0], 3) - blocks[0].observations.xy
        r = adjust_replicates(blocks[0], ap_models.get("optical"), xy)
        assert r.ok.all()
        for trial in range(3):
            of_trial = blocks[0].replace_image_points(xy[trial])
            assert largest_difference(r, trial, of_trial, ap_models.get("optical")) < SAME_MINIMUM


def names(block: Block) -> list[tuple[str, str]]:
    o = block.observations
    return [(block.images.ids[i], block.points.ids[p]) for i, p in zip(o.image, o.point, strict=True)]


def only(block: Block, pairs: set[tuple[str, str]]) -> Block:
    from simfield.block.block import ImageObservations

    kept = np.array([pair in pairs for pair in names(block)])
    o = block.observations
    observations = ImageObservations(o.image[kept], o.point[kept], o.xy[kept], o.sigma[kept])
    order = np.lexsort((observations.point, observations.image))
    observations = ImageObservations(*(getattr(observations, n)[order] for n in ("image", "point", "xy", "sigma")))
    return Block(block.cameras, block.images, block.points, observations)


class TestSameBits:
    def test_for_any_number_of_processes_and_any_neighbours(self) -> None:
        world = build_world(presets["rheidt-1980"], 3)
        block, _ = world.observe(0)
        model = ap_models.get("torlegard")
        draws = world.draws(0, 600)
        one = adjust_replicates(block, model, draws)
        two = adjust_replicates(block, model, draws, jobs=2)
        from_array = adjust_replicates(block, model, draws[0:64])
        later = adjust_replicates(block, model, world.draws(32, 64))
        assert np.array_equal(one.trials.x, two.trials.x)
        assert np.array_equal(one.trials.x[:64], from_array.trials.x)
        assert np.array_equal(one.trials.x[32:64], later.trials.x)

    def test_an_array_in_two_processes(self, ww_world: synthetic.World) -> None:
        xy = noisy(ww_world.block, 600)
        one = adjust_replicates(ww_world.block, None, xy)
        two = adjust_replicates(ww_world.block, None, xy, jobs=2)
        assert np.array_equal(one.trials.x, two.trials.x)


class TestQuality:
    def test_standard_deviations(self, ww_world: synthetic.World) -> None:
        block, model = ww_world.block, ap_models.get("optical")
        xy = noisy(block, 3)
        nominal = adjust_replicates(block, model, xy)
        exact = adjust_replicates(block, model, xy, exact_std=True)
        for trial in range(3):
            std = adjust_block(block.replace_image_points(xy[trial]), model).std
            np.testing.assert_allclose(exact.std[trial], std, rtol=1e-9, atol=1e-15)
            free = std > 0.0
            assert np.abs(nominal.std[trial, free] / std[free] - 1.0).max() < STD_NOMINAL

    def test_sigma0_and_what_hangs_on_it(self, ww_world: synthetic.World) -> None:
        block = ww_world.block
        xy = noisy(block, 2)
        r = adjust_replicates(block, None, xy)
        a = adjust_block(block.replace_image_points(xy[1]))
        assert r.sigma0[1] == pytest.approx(a.sigma0, rel=1e-12)
        assert r.m0_um[1] == pytest.approx(a.m0_um, rel=1e-12)
        np.testing.assert_allclose(r.points[1], a.coordinates, rtol=0.0, atol=1e-7)
        np.testing.assert_allclose(r.images[1], a.exterior, rtol=0.0, atol=1e-7)
        assert r.status == [Status.CONVERGED] * 2

    def test_a_failed_trial_is_a_trial(self, ww_world: synthetic.World) -> None:
        """A trial that no adjustment can solve is NaN with its status, and its neighbours are as ever."""
        block = ww_world.block
        xy = noisy(block, 3)
        alone = adjust_replicates(block, None, xy)
        xy[1] = -xy[1]
        r = adjust_replicates(block, None, xy)
        assert np.array_equal(r.trials.x[[0, 2]], alone.trials.x[[0, 2]])
        if not r.ok[1]:
            assert np.isnan(r.trials.x[1]).all()
            assert np.isnan(r.sigma0[1])
        else:
            assert r.sigma0[1] > 10.0


class TestCalls:
    def test_no_trials(self, ww_world: synthetic.World) -> None:
        block = ww_world.block
        r = adjust_replicates(block, None, np.empty((0, len(block.observations), 2)))
        assert len(r) == 0
        assert r.points.shape == (0, len(block.points), 3)

    def test_shapes_are_named(self, ww_world: synthetic.World) -> None:
        with pytest.raises(ValueError, match=r"needed is \(t, 3"):
            adjust_replicates(ww_world.block, None, np.zeros((2, 3, 2)))
        xy = noisy(ww_world.block, 2)
        with pytest.raises(ValueError, match="coordinates has shape"):
            adjust_replicates(ww_world.block, None, xy, coordinates=np.zeros((1, 2, 3)))

    def test_a_set_without_name(self, ww_world: synthetic.World) -> None:
        r = adjust_replicates(ww_world.block, None, noisy(ww_world.block, 1))
        with pytest.raises(KeyError, match="no additional parameters"):
            r.ap("no such camera")


@pytest.mark.parametrize("redrawn", [False, True])
def test_memory_that_others_have_used_changes_no_bit(two_camera_world: synthetic.World, redrawn: bool) -> None:
    """An arena is taken again and again; here it holds what no result survives."""
    block = weighted(two_camera_world.block, 0.03)
    points, chord = noisy(block, 40), prepared(block, ap_models.get("optical"))
    given = np.repeat(block.points.coordinates[None], 40, axis=0) if redrawn else None
    clean = adjust_prepared(chord, points, coordinates=given)
    arena = Arena()
    arena.array(1 << 21)[:] = np.nan
    used = adjust_prepared(chord, points, coordinates=given, arena=arena)
    again = adjust_prepared(chord, points, coordinates=given, arena=arena)
    assert clean.ok.all()
    for other in (used, again):
        np.testing.assert_array_equal(other.trials.x, clean.trials.x)
        np.testing.assert_array_equal(other.trials.vpv, clean.trials.vpv)
