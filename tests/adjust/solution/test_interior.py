"""Interior orientation estimated (brown1971): close-range calibration, derivatives, and refusal where it cannot be."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adjust import Status, adjust_block, ap_models
from adjust.model.unknowns import Unknowns
from adjust.observations.observations import Observations
from adjust.solution.determinability import LEAST_SHARE, shares
from adjust.trials.replicates import adjust_replicates
from adjust.trials.solved import GAUSS_NEWTON
from simfield.block import Block, Camera, Floats, ImageObservations, Images, Points
from tests.adjust.close_range import LENS, NOMINAL, CloseRange, close_range
from tests.synthetic import QUARTERS, WW, fly, quincunx, world

BROWN = ap_models.get("brown1971", c_mm=NOMINAL.c_mm)
NAMES = tuple(LENS)
TRUE = np.array(list(LENS.values()))
RECOVERED = 1e-9
"""m, mm, and for the lens the same at the corner of the format, mm"""
SETUPS = range(10)
TRIALS = 40
CORNER = np.array([[17.0, 11.0]])


def effect_at_corner(values: Floats) -> Floats:
    """(10) what each parameter moves the corner of the format by, mm; 1 % of it for the principal distance."""
    size = np.abs(BROWN.basis(*CORNER.T)).max(axis=(0, 1))
    return np.asarray(values * size)


@pytest.fixture(scope="module")
def noisy() -> CloseRange:
    return close_range(3, noise_um=0.5)


@pytest.mark.parametrize("seed", SETUPS)
def test_a_close_range_calibration_finds_the_lens(seed: int) -> None:
    w = close_range(seed)
    a = adjust_block(w.block, BROWN)
    assert a.status is Status.CONVERGED, a.message
    assert np.abs(w.exterior[:, 3]).max() > np.radians(40.0)
    assert np.abs(np.abs(w.exterior[:, 5]) - np.pi).min() < np.radians(2.0)
    assert a.ap["slr"].names == NAMES
    assert np.abs(effect_at_corner(a.ap["slr"].values - TRUE)).max() < RECOVERED
    assert np.abs(a.coordinates - w.coordinates).max() < RECOVERED
    assert np.abs(a.exterior[:, :3] - w.exterior[:, :3]).max() < RECOVERED


def test_jacobian_by_central_differences(noisy: CloseRange) -> None:
    a = adjust_block(noisy.block, BROWN)
    points = a.groups.image_points
    at = points.jacobian(a.x)
    for j, column in enumerate(range(a.layout.sets[0].columns.start, a.layout.sets[0].columns.stop)):
        step = np.zeros_like(a.x)
        step[column] = 1e-4 / np.abs(at.by_orientation[:, :, 6 + j]).max()
        difference = (points.residuals(a.x + step)[0] - points.residuals(a.x - step)[0]) / (2.0 * step[column])
        scale = np.abs(difference).max()
        np.testing.assert_allclose(at.by_orientation[:, :, 6 + j], difference, rtol=0.0, atol=1e-8 * scale)


def test_compiled_and_plain_arithmetic_agree(noisy: CloseRange) -> None:
    fast, plain = (adjust_block(noisy.block, BROWN, compiled=compiled) for compiled in (True, False))
    np.testing.assert_allclose((fast.x - plain.x) / np.where(plain.std > 0.0, plain.std, 1.0), 0.0, atol=1e-7)
    np.testing.assert_allclose(fast.std, plain.std, rtol=1e-6)


def test_at_the_estimate_the_gradient_vanishes(noisy: CloseRange) -> None:
    """With new derivatives: the iteration must not have stayed with those of its start."""
    a = adjust_block(noisy.block, BROWN)
    again = a.arithmetic.at(a.x)
    step, length = a.arithmetic.factorise(again).step(again)
    assert length < 1e-6
    assert np.isfinite(step).all()


def test_replicates_are_what_single_adjustments_find(noisy: CloseRange) -> None:
    rng = np.random.default_rng(11)
    o = noisy.block.observations
    trials = o.xy + 0.0005 * rng.standard_normal((3, *o.xy.shape))
    found = adjust_replicates(noisy.block, BROWN, trials)
    assert found.finished_by_gauss_newton == 3
    assert (found.trials.route == GAUSS_NEWTON).all()
    for trial, xy in enumerate(trials):
        alone = adjust_block(noisy.block.replace_image_points(xy), BROWN)
        np.testing.assert_allclose(
            found.ap("slr")[trial], alone.ap["slr"].values, atol=1e-6 * alone.ap["slr"].std.max()
        )
        assert found.sigma0[trial] == pytest.approx(alone.sigma0, rel=1e-9)


@pytest.mark.slow
def test_intervals_cover_the_lens_as_often_as_they_say() -> None:
    """Ten set-ups of 40 trials each: 95 % intervals of ten parameters, and sigma0 in the mean."""
    inside, sigma0 = [], []
    for seed in SETUPS:
        w = close_range(seed)
        o = w.block.observations
        rng = np.random.default_rng(100 + seed)
        found = adjust_replicates(w.block, BROWN, o.xy + o.sigma * rng.standard_normal((TRIALS, *o.xy.shape)))
        assert found.ok.all()
        columns = found.nominal.layout.sets[0].columns
        std = np.sqrt(found.nominal.cofactors.diagonal[columns]) * found.sigma0[:, None]
        inside.append(np.abs(found.ap("slr") - TRUE) <= 1.9605 * std)
        sigma0.append(found.sigma0)
    share = np.mean(inside)
    # parameters of one trial are correlated: as if two of the ten were independent, the standard error is 0.8 %
    assert abs(share - 0.95) < 3.0 * np.sqrt(0.95 * 0.05 / (2 * TRIALS * len(SETUPS)))
    assert np.mean(sigma0) == pytest.approx(1.0, abs=4.0 * 0.012 / np.sqrt(TRIALS * len(SETUPS)))


def flat_and_vertical(tilt_rad: float = 0.0, relief_m: float = 0.0):
    return world([(WW, fly(WW, 10000.0, QUARTERS, tilt_rad))], quincunx(relief_m=relief_m), sigma_mm=0.004)


def test_a_flat_vertical_block_is_refused_by_name() -> None:
    a = adjust_block(flat_and_vertical().block, ap_models.get("brown1971"))
    assert a.status is Status.SINGULAR
    for name in ("dc of camera ww", "xp of camera ww", "yp of camera ww", "Z0 of all 12 images", "cannot be separated"):
        assert name in a.message


def test_a_nearly_flat_and_vertical_block_says_what_is_weak() -> None:
    w = flat_and_vertical(0.01, 3.0)
    noisy = w.with_noise(np.random.default_rng(2))
    a = adjust_block(noisy.block, ap_models.get("brown1971"))
    assert a.status.ok
    assert a.message.startswith(
        "converged: dc of camera ww is hardly determined (a change of scale, as Z0 of every image gives it)"
    )
    assert "% of its effect" in a.message
    assert 'leave out without=("dc",' in a.message


def test_standard_deviations_of_what_is_weak_are_true() -> None:
    """The lens is as assumed; an error of many millimetres in the principal distance, as often as is said."""
    w, random = flat_and_vertical(0.01, 3.0), np.random.default_rng(3)
    squares, inside = [], []
    for _ in range(40):
        a = adjust_block(w.with_noise(random).block, ap_models.get("brown1971"))
        assert a.status.ok, a.message
        z = a.ap["ww"].values[:3] / a.ap["ww"].std[:3]
        squares.append(float(np.mean(z**2)))
        inside.append(np.abs(z) < 1.96)
    mean, error = np.mean(squares), np.std(squares, ddof=1) / np.sqrt(len(squares))
    assert abs(mean - 1.0) < 3.5 * error


@pytest.mark.parametrize("c_mm", [300.0, 600.0])
def test_a_long_lens_is_calibrated(c_mm: float) -> None:
    """A few degrees of view and less: how little is known of the principal point is said, and true."""
    random, squares = np.random.default_rng(5), []
    for _ in range(20):
        block, true = long_lens(c_mm, random)
        a = adjust_block(block, ap_models.get("brown1971", without=("K2", "K3", "P1", "P2", "B1", "B2")))
        assert a.status.ok, a.message
        at = [a.ap["tele"].names.index(name) for name in ("dc", "xp", "yp")]
        squares.append(float(np.mean(((a.ap["tele"].values[at] - true) / a.ap["tele"].std[at]) ** 2)))
    mean, error = np.mean(squares), np.std(squares, ddof=1) / np.sqrt(len(squares))
    assert abs(mean - 1.0) < 3.5 * error


def long_lens(c_mm: float, random: np.random.Generator) -> tuple[Block, Floats]:
    """Twelve convergent images of a cube of 60 points with four fixed ones; and dc, xp, yp that are true, mm."""
    true = np.array([5.0, 0.4, -0.3])
    points = random.uniform(-0.5, 0.5, (60, 3))
    distance = 0.9 * c_mm / 24.0
    exterior, rows = [], []
    for image in range(12):
        tilt, azimuth = np.deg2rad(45.0), 2.0 * np.pi * image / 12
        turn = Rotation.from_euler("ZXZ", [azimuth, tilt, 0.5 * np.pi * image])
        axes = turn.as_matrix()
        place = distance * axes[:, 2]
        exterior.append(np.concatenate([place, Rotation.from_matrix(axes).as_euler("XYZ")]))
        seen = (points - place) @ axes
        xy = -(c_mm + true[0]) * seen[:, :2] / seen[:, 2:] + true[1:]
        rows.append(xy + 0.001 * random.standard_normal(xy.shape))
    control = np.arange(60) < 4
    return (
        Block(
            (Camera("tele", c_mm, 0.0, 0.0, 36.0, 24.0),),
            Images(tuple(f"i{i}" for i in range(12)), np.zeros(12, dtype=np.intp), np.array(exterior)),
            Points(
                tuple(f"p{i}" for i in range(60)),
                np.where(control, "control", "tie"),
                points,
                np.where(control[:, None], 0.0, np.nan) * np.ones((60, 3)),
            ),
            ImageObservations(
                np.repeat(np.arange(12), 60), np.tile(np.arange(60), 12), np.vstack(rows), np.full((720, 2), 0.001)
            ),
        ),
        true,
    )


@pytest.mark.parametrize("tilt_rad", [0.0, 0.01])
def test_without_the_interior_orientation_it_is_not(tilt_rad: float) -> None:
    model = ap_models.get("brown1971", without=("dc", "xp", "yp"))
    assert model.parameters == ("K1", "K2", "K3", "P1", "P2", "B1", "B2")
    noisy = flat_and_vertical(tilt_rad, 3.0).with_noise(np.random.default_rng(2))
    a = adjust_block(noisy.block, model)
    assert a.status is Status.CONVERGED, a.message
    assert (np.abs(a.ap["ww"].values) < 4.0 * a.ap["ww"].std).all()


def test_relief_lets_the_interior_orientation_be_estimated() -> None:
    w = flat_and_vertical(0.05, 400.0)
    a = adjust_block(w.block, ap_models.get("brown1971"))
    assert a.status is Status.CONVERGED, a.message
    np.testing.assert_allclose(a.ap["ww"].values[:3], 0.0, atol=1e-7)


def test_shares_are_those_of_the_design_matrix(noisy: CloseRange) -> None:
    a = adjust_block(noisy.block, BROWN)
    u = Unknowns.of(noisy.block, BROWN)
    g = Observations.of(noisy.block, u).image_points
    at = g.jacobian(a.x)
    k, size = len(g.image), len(a.x)
    design = np.zeros((2 * k, size))
    for i, (image, point) in enumerate(zip(g.image, g.point, strict=True)):
        rows = slice(2 * i, 2 * i + 2)
        design[rows, 6 * image : 6 * image + 6] = at.by_orientation[i, :, :6]
        design[rows, u.sets[0].columns] = at.by_orientation[i, :, 6:]
        design[rows, u.orientation + 3 * point : u.orientation + 3 * point + 3] = at.by_point[i]
    length = np.linalg.norm(design, axis=0)
    design /= np.where(length > 0.0, length, 1.0)
    columns = np.arange(u.sets[0].columns.start, u.sets[0].columns.start + 3)
    found = shares(a.layout, a.arithmetic, a.x, columns)
    assert (found > LEAST_SHARE).all()
    for share, column in zip(found, columns, strict=True):
        others = np.delete(design, column, axis=1)
        left = design[:, column] - others @ np.linalg.lstsq(others, design[:, column], rcond=None)[0]
        assert np.linalg.norm(left) == pytest.approx(share, rel=1e-6)
