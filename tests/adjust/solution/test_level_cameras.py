"""Level cameras: an image that looks along the X axis of the object frame is as good as any other.

A ring of level cameras round a cloud of points, turned as a whole: sigma0, residuals, points and their precision may
not hang on how the object frame lies. The blocks and their rotations are made here, without the product's.
"""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from adjust import Adjustment, adjust_block, adjust_replicates, ap_models
from adjust.bundle import reweighted
from adjust.datum import InnerConstraints
from adjust.model import rotation, unknowns
from adjust.observations.stations import StationAttitudes
from adjust.quality import Reliability
from simfield.block import Block, Camera, Floats, ImageObservations, Images, Points

C_MM, RADIUS_M, SIGMA_MM = 50.0, 10.0, 0.005
SAME = 1e-8
"""sigma0 and residuals over sigma, of two adjustments that each end within 1e-9 standard deviations"""
SAME_M = 1e-9
GIMBALS = {
    "along X": np.eye(3),
    "X to Y": Rotation.from_euler("z", 90, degrees=True).as_matrix(),
    "X to Z": Rotation.from_euler("y", 90, degrees=True).as_matrix(),
    "a second of arc off": Rotation.from_euler("zy", [1, 1], degrees=True).as_matrix() @ np.eye(3),
    **{f"any {n}": Rotation.random(random_state=n).as_matrix() for n in range(4)},
}


def ring(turn: Floats, images: int = 8, points: int = 30, control: int = 5, seed: int = 1) -> tuple[Block, Floats]:
    """A block of level cameras in a ring, turned as a whole, with true orientations to start from; and its points."""
    random = np.random.default_rng(seed)
    place = random.uniform(-2.0, 2.0, (points, 3))
    azimuth = 2.0 * np.pi * np.arange(images) / images
    back = np.column_stack([np.cos(azimuth), np.sin(azimuth), np.zeros(images)])
    right = np.cross([0.0, 0.0, 1.0], back)
    axes = np.stack([right, np.cross(back, right), back], axis=2)
    station = RADIUS_M * back
    camera = np.einsum("mij,mni->mnj", axes, place[None] - station[:, None])
    xy = (-C_MM * camera[..., :2] / camera[..., 2:]).reshape(-1, 2) + SIGMA_MM * random.standard_normal(
        (images * points, 2)
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # scipy says so where it sets one of two angles to zero
        angles = Rotation.from_matrix(turn @ axes).as_euler("XYZ")
    place, station = place @ turn.T, station @ turn.T
    is_control = np.arange(points) < control
    return Block(
        (Camera("c", C_MM, 0.0, 0.0, 36.0, 24.0),),
        Images(tuple(f"i{i}" for i in range(images)), np.zeros(images, dtype=np.intp), np.hstack([station, angles])),
        Points(
            tuple(f"p{i}" for i in range(points)),
            np.where(is_control, "control", "tie"),
            np.where(is_control[:, None], place, np.nan),
            np.where(is_control[:, None], 0.001, np.nan) * np.ones((points, 3)),
        ),
        ImageObservations(
            np.repeat(np.arange(images), points),
            np.tile(np.arange(points), images),
            xy,
            np.full_like(xy, SIGMA_MM),
        ),
    ), place


def angle_between(a: Adjustment, angles: Floats) -> float:
    """The largest rotation between estimated attitudes and angles (m, 3), rad."""
    both = (Rotation.from_euler("XYZ", each) for each in (a.exterior[:, 3:], angles))
    first, second = both
    return float((first * second.inv()).magnitude().max())


def image_redundancy(a: Adjustment) -> Floats:
    """(2k) the redundancy numbers of the image coordinates; those of control components hang on the frame."""
    return Reliability.of(a).redundancy[: a.residuals.size]


@pytest.fixture(scope="module")
def unturned() -> Adjustment:
    return adjust_block(ring(Rotation.from_euler("zyx", [20, 10, 30], degrees=True).as_matrix())[0])


@pytest.mark.parametrize("turn", GIMBALS.values(), ids=GIMBALS)
@pytest.mark.parametrize("compiled", [True, False])
def test_nothing_hangs_on_how_the_object_frame_lies(turn: Floats, compiled: bool, unturned: Adjustment) -> None:
    block, _ = ring(turn)
    a = adjust_block(block, compiled=compiled)
    assert a.message == "converged"
    assert a.sigma0 == pytest.approx(unturned.sigma0, rel=SAME)
    np.testing.assert_allclose(a.residuals, unturned.residuals, rtol=0.0, atol=SAME * SIGMA_MM)
    np.testing.assert_allclose(image_redundancy(a), image_redundancy(unturned), rtol=0.0, atol=SAME)
    spread = [np.trace(each.cofactors.points, axis1=1, axis2=2) for each in (a, unturned)]
    np.testing.assert_allclose(spread[0], spread[1], rtol=1e-6)
    assert angle_between(a, block.images.exterior[:, 3:]) < 1e-3


def test_a_free_network_and_other_weights_do_not_hang_on_it_either(unturned: Adjustment) -> None:
    block, _ = ring(np.eye(3))
    free = [adjust_block(each, datum=InnerConstraints()) for each in (block, unturned.block)]
    assert free[0].sigma0 == pytest.approx(free[1].sigma0, rel=SAME)
    assert free[0].points.std.sum() == pytest.approx(free[1].points.std.sum(), rel=0.05)  # of turned components
    np.testing.assert_allclose(*(np.trace(f.cofactors.points, axis1=1, axis2=2) for f in free), rtol=1e-6)
    half = [reweighted(f, 0.25 * f.groups.weights) for f in (adjust_block(block), unturned)]
    assert half[0].sigma0 == pytest.approx(half[1].sigma0, rel=SAME)


def test_many_trials_are_those_of_single_adjustments() -> None:
    block, _ = ring(np.eye(3))
    o, random = block.observations, np.random.default_rng(7)
    trials = o.xy + SIGMA_MM * random.standard_normal((40, *o.xy.shape))
    model = ap_models.get("none")
    many = adjust_replicates(block, model, trials)
    assert many.finished_by_gauss_newton < 4  # with a wrong gradient, all
    assert many.nominal.layout.renamed is not None
    for trial in (0, 17, 39):
        own = Block(
            block.cameras, block.images, block.points, ImageObservations(o.image, o.point, trials[trial], o.sigma)
        )
        alone = adjust_block(own, model)
        assert many.sigma0[trial] == pytest.approx(alone.sigma0, rel=SAME)
        np.testing.assert_allclose(many.points[trial], alone.coordinates, rtol=0.0, atol=SAME_M)
        assert angle_between(alone, many.images[trial][:, 3:]) < SAME_M


def test_angles_of_people_have_their_own_standard_deviations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Eight degrees off the axis both kinds of unknowns are good, so the told standard deviations must agree."""
    turn = Rotation.from_euler("zyx", [3, -7, 40], degrees=True).as_matrix()
    block, _ = ring(turn)
    told = adjust_block(block, ap_models.get("optical"))
    assert told.layout.renamed is not None
    monkeypatch.setattr(unknowns, "steep", lambda angles: np.zeros(len(angles), dtype=bool))
    plain = adjust_block(block, ap_models.get("optical"))
    assert plain.layout.renamed is None
    np.testing.assert_allclose(told.images.values, plain.images.values, rtol=0.0, atol=SAME_M)
    np.testing.assert_allclose(told.images.std, plain.images.std, rtol=1e-6)
    np.testing.assert_allclose(told.cofactors.orientation, plain.cofactors.orientation, rtol=0.0, atol=1e-9)
    names = [("i0", "omega"), ("i0", "kappa"), ("i4", "phi"), ("c", "a3"), ("p9", "Z"), ("i2", "Z0")]
    np.testing.assert_allclose(told.correlation(*names), plain.correlation(*names), rtol=0.0, atol=1e-6)


def test_at_the_gimbal_itself_omega_and_kappa_are_said_to_be_undetermined_and_all_else_is_not() -> None:
    a = adjust_block(ring(np.eye(3))[0])
    degrees = np.rad2deg(a.images.std[:, 3:])
    assert (degrees[[0, 4]][:, [0, 2]] > 1.0).all()
    assert (degrees[[0, 4], 1] < 0.1).all()
    assert (degrees[[1, 2, 3, 5, 6, 7]] < 0.1).all()
    r = a.correlation(("i0", "omega"), ("i0", "kappa"))[0, 1]
    assert abs(r) == pytest.approx(1.0, abs=1e-4)


def test_observed_attitudes_along_the_axis() -> None:
    block, _ = ring(np.eye(3))
    ids, angles = block.images.ids, block.images.exterior[:, 3:]
    held = adjust_block(block, observations=[StationAttitudes(ids, angles, np.full((8, 3), 1e-4))])
    assert held.message == "converged"
    assert angle_between(held, angles) < 5e-4
    uneven = np.full((8, 3), 1e-4)
    uneven[0, 0] = 1e-3
    with pytest.raises(ValueError, match="attitude of image 'i0': it looks along the X axis"):
        adjust_block(block, observations=[StationAttitudes(ids, angles, uneven)])


@pytest.mark.parametrize("seed", range(20))
def test_angles_come_back_from_any_rotation(seed: int) -> None:
    random = np.random.default_rng(seed)
    angles = random.uniform(-np.pi, np.pi, (6, 3))
    angles[:, 1] = [0.0, 1.0, 0.5 * np.pi, -0.5 * np.pi, 0.5 * np.pi - 1e-7, random.uniform(-1.5, 1.5)]
    for renamed in (None, np.arange(6) % 2 == 0, np.ones(6, dtype=bool)):
        own = rotation.rotation_matrices(angles, renamed)
        again = rotation.rotation_matrices(rotation.angles_of(own, renamed), renamed)
        np.testing.assert_allclose(again, own, rtol=0.0, atol=1e-8)
