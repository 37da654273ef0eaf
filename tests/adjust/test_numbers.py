"""Numbers of unusual size, order and name."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Status, adjust_block, ap_models
from simfield.block.block import Block, Camera, ImageObservations, Images, Points
from tests import synthetic

MODEL = ap_models.get("optical")


@pytest.fixture(scope="module")
def noisy(two_camera_world: synthetic.World) -> synthetic.World:
    return two_camera_world.with_noise(np.random.default_rng(21))


def test_national_coordinates(noisy: synthetic.World) -> None:
    """The reduction to an origin keeps the digits: the result moves with the coordinates."""
    shift = np.array([5_568_123.25, 5_641_987.75, 1345.5])  # exact in binary, so the data are the same
    w = noisy.started_at(noisy.exterior + np.r_[shift, 0.0, 0.0, 0.0])
    far = adjust_block(w.with_points(coordinates=w.block.points.coordinates + shift).block, MODEL)
    near = adjust_block(noisy.block, MODEL)
    assert far.status.ok, far.message
    std = np.where(near.points.std > 0.0, near.points.std, 1.0)
    # coordinates of 5e6 m are rounded to 9e-10 m; relief has random digits
    assert (np.abs(far.points.values - shift - near.points.values) <= 2e-9 + 1e-8 * std).all()
    np.testing.assert_allclose(far.ap["ww"].values, near.ap["ww"].values, rtol=0.0, atol=1e-6 * near.ap["ww"].std.max())
    np.testing.assert_allclose(far.std, near.std, rtol=1e-7)
    assert far.sigma0 == pytest.approx(near.sigma0, rel=1e-9)


@pytest.mark.parametrize("factor", [1e-6, 1e-3, 1e3, 1e6])
def test_the_unit_of_weight_does_not_matter(noisy: synthetic.World, factor: float) -> None:
    o = noisy.block.observations
    other = ImageObservations(o.image, o.point, o.xy, o.sigma * factor)
    a = adjust_block(Block(noisy.block.cameras, noisy.block.images, noisy.block.points, other), MODEL)
    b = adjust_block(noisy.block, MODEL)
    assert a.status.ok, a.message
    np.testing.assert_allclose(a.points.values, b.points.values, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(a.std, b.std, rtol=1e-6)
    assert a.sigma0 == pytest.approx(b.sigma0 / factor, rel=1e-9)
    assert a.m0_um == pytest.approx(b.m0_um, rel=1e-9)


def test_every_observation_with_a_sigma_of_its_own(two_camera_world: synthetic.World) -> None:
    """Over four powers of ten: the bad ones do no harm, and sigma0 is 1."""
    rng = np.random.default_rng(5)
    o = two_camera_world.block.observations
    sigma = 10.0 ** rng.uniform(-4.0, 0.0, o.sigma.shape)
    b = two_camera_world.block
    mixed = ImageObservations(o.image, o.point, o.xy + sigma * rng.standard_normal(sigma.shape), sigma)
    a = adjust_block(Block(b.cameras, b.images, b.points, mixed), MODEL)
    assert a.status.ok, a.message
    assert abs(a.sigma0 - 1.0) < 4.0 / np.sqrt(2.0 * a.redundancy)
    error = (a.points.values - two_camera_world.coordinates)[~b.points.fixed] / a.points.std[~b.points.fixed]
    assert 0.85 < np.sqrt(np.mean(error**2)) < 1.15
    assert a.unit_weight_um == pytest.approx(1000.0 * sigma.min(), rel=1e-14)


def test_ids_of_any_kind(noisy: synthetic.World) -> None:
    b = noisy.block
    odd = ["ä ö", "1e5", "nan", "", "-", "None", "a,b", '"', "x of image y", "点", "0x10", " inner  blanks"]
    names = tuple((odd[i % len(odd)] + f"#{i}").strip() for i in range(len(b.points)))
    images = tuple(f"Bild {i}/{len(b.images)} 'ß'" for i in range(len(b.images)))
    cameras = (Camera("RMK A 15/23", *_interior(b.cameras[0])), Camera("{0}%s", *_interior(b.cameras[1])))
    renamed = Block(
        cameras,
        Images(images, b.images.camera, b.images.exterior),
        Points(names, b.points.role, b.points.coordinates, b.points.sigma),
        b.observations,
    )
    a, plain = adjust_block(renamed, MODEL), adjust_block(b, MODEL)
    np.testing.assert_array_equal(a.x, plain.x)
    assert set(a.ap) == {"RMK A 15/23", "{0}%s"}
    assert a.correlation(("{0}%s", "a3"), (images[3], "Z0"), (names[9], "Z")).shape == (3, 3)
    free = adjust_block(Block(cameras, renamed.images, _tied(renamed.points), renamed.observations), MODEL)
    assert free.status is Status.SINGULAR


def _interior(camera: Camera) -> tuple[float, float, float, float, float]:
    return camera.c_mm, camera.x0_mm, camera.y0_mm, camera.width_mm, camera.height_mm


def _tied(points: Points) -> Points:
    return Points(points.ids, np.full(len(points), "tie"), points.coordinates, np.full((len(points), 3), np.nan))


def test_a_camera_without_images(noisy: synthetic.World) -> None:
    b = noisy.block
    spare = Camera("spare", 100.0, 0.0, 0.0, 230.0, 230.0)
    block = Block(
        (spare, *b.cameras), Images(b.images.ids, b.images.camera + 1, b.images.exterior), b.points, b.observations
    )
    a, plain = adjust_block(block, MODEL), adjust_block(b, MODEL)
    np.testing.assert_array_equal(a.x, plain.x)
    assert set(a.ap) == {"ww", "sww"}
    assert adjust_block(block, {"ww": MODEL, "sww": MODEL}).status.ok
    with pytest.raises(KeyError):
        a.ap_correlation("spare")


def test_cameras_in_alternation(noisy: synthetic.World) -> None:
    """Images of the cameras need not stand together."""
    b = noisy.block
    order = np.random.default_rng(2).permutation(len(b.images))
    place = np.argsort(order)
    images = Images(tuple(b.images.ids[i] for i in order), b.images.camera[order], b.images.exterior[order])
    o = b.observations
    block = Block(b.cameras, images, b.points, ImageObservations(place[o.image], o.point, o.xy, o.sigma))
    a, plain = adjust_block(block, MODEL), adjust_block(b, MODEL)
    np.testing.assert_allclose(a.images.values[place], plain.images.values, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(a.ap["sww"].std, plain.ap["sww"].std, rtol=1e-9)


def test_one_image_over_control() -> None:
    """A resection is an adjustment like any other."""
    flight = synthetic.fly(synthetic.WW, 10500.0, headings=(0.0,))[1:2]
    field = synthetic.quincunx()
    w = synthetic.world([(synthetic.WW, flight)], field, control=tuple(field)).with_noise(np.random.default_rng(1))
    a = adjust_block(w.block)
    assert a.status.ok, a.message
    assert a.redundancy == 2 * 41 - 6
    assert np.isfinite(a.images.std).all()
    np.testing.assert_array_equal(a.points.values, w.block.points.coordinates)


def test_the_block_is_left_alone(noisy: synthetic.World) -> None:
    before = noisy.block.images.exterior.copy(), noisy.block.points.coordinates.copy()
    a = adjust_block(noisy.block, MODEL)
    np.testing.assert_array_equal(noisy.block.images.exterior, before[0])
    np.testing.assert_array_equal(noisy.block.points.coordinates, before[1])
    assert a.block is noisy.block


def test_the_same_call_gives_the_same_bits(noisy: synthetic.World) -> None:
    a, b = adjust_block(noisy.block, MODEL), adjust_block(noisy.block, MODEL)
    np.testing.assert_array_equal(a.x, b.x)
    np.testing.assert_array_equal(a.std, b.std)
