"""Rough starts end at the same minimum."""

from __future__ import annotations

import numpy as np
import pytest

from adjust import Adjustment, adjust_block, ap_models
from simfield.block.block import Floats
from tests import synthetic

SAME_MINIMUM = 1e-8
"""of a standard deviation: the rule by which the iteration ends"""
ROUNDING = 1e-12
"""of coordinates of 1000 m"""


@pytest.fixture(scope="module")
def noisy(two_camera_world: synthetic.World) -> synthetic.World:
    return two_camera_world.with_noise(np.random.default_rng(8))


@pytest.fixture(scope="module")
def best(noisy: synthetic.World) -> Adjustment:
    a = adjust_block(noisy.block, ap_models.get("brown14"))
    assert a.status.ok, a.message
    return a


def assert_same_minimum(a: Adjustment, best: Adjustment) -> None:
    assert a.status.ok, a.message
    assert (np.abs(estimates(a) - estimates(best)) <= SAME_MINIMUM * best.std + ROUNDING).all()
    assert a.sigma0 == pytest.approx(best.sigma0, rel=1e-12)


def estimates(a: Adjustment) -> Floats:
    """All estimates in the order of x, unreduced (the origin follows the start values)."""
    ap = [p.values for p in a.ap.values()]
    return np.concatenate([a.images.values.ravel(), *ap, a.points.values.ravel()])


def disturbed(exterior: Floats, seed: int, of_height: float, degrees: float) -> Floats:
    """Every coordinate wrong by up to `of_height` of the flying height, every angle by up to `degrees`."""
    rng = np.random.default_rng(seed)
    off = rng.uniform(-1.0, 1.0, exterior.shape)
    return exterior + np.hstack([off[:, :3] * of_height * exterior[:, 2:3], off[:, 3:] * np.deg2rad(degrees)])


@pytest.mark.parametrize("seed", range(20))
def test_orientations_wrong_by_1_percent_and_2_degrees(noisy: synthetic.World, best: Adjustment, seed: int) -> None:
    started = noisy.started_at(disturbed(noisy.exterior, seed, of_height=0.01, degrees=2.0))
    assert_same_minimum(adjust_block(started.block, ap_models.get("brown14")), best)


@pytest.mark.parametrize("seed", range(3))
def test_there_is_reserve(noisy: synthetic.World, best: Adjustment, seed: int) -> None:
    started = noisy.started_at(disturbed(noisy.exterior, seed, of_height=0.05, degrees=8.0))
    assert_same_minimum(adjust_block(started.block, ap_models.get("brown14")), best)


def test_no_approximate_orientation_at_all(noisy: synthetic.World, best: Adjustment) -> None:
    """Near-vertical images with three control points each or more start from these."""
    nothing = noisy.started_at(np.full_like(noisy.exterior, np.nan))
    a = adjust_block(nothing.block, ap_models.get("brown14"))
    assert a.status.ok, a.message
    assert a.sigma0 == pytest.approx(best.sigma0, rel=1e-12)
    np.testing.assert_allclose(a.points.values, best.points.values, rtol=0.0, atol=1e-8)
    # kappa may differ by full turns
    np.testing.assert_allclose(np.cos(a.images.values[:, 5]), np.cos(best.images.values[:, 5]), rtol=0.0, atol=1e-9)


def test_some_images_without_approximate_orientation(noisy: synthetic.World, best: Adjustment) -> None:
    exterior = noisy.exterior.copy()
    exterior[[0, 1, 7, 23]] = np.nan
    a = adjust_block(noisy.started_at(exterior).block, ap_models.get("brown14"))
    assert a.status.ok, a.message
    np.testing.assert_allclose(a.points.values, best.points.values, rtol=0.0, atol=1e-8)


def test_wrong_start_coordinates_of_tie_points_do_no_harm(noisy: synthetic.World, best: Adjustment) -> None:
    p = noisy.block.points
    off = noisy.coordinates + np.random.default_rng(9).normal(0.0, 20.0, noisy.coordinates.shape)
    coordinates = np.where(p.fixed, p.coordinates, off)
    a = adjust_block(noisy.with_points(coordinates=coordinates).block, ap_models.get("brown14"))
    assert a.status.ok, a.message
    np.testing.assert_allclose(a.points.values, best.points.values, rtol=0.0, atol=1e-8)


def test_starting_again_from_the_result_takes_no_effort(noisy: synthetic.World, best: Adjustment) -> None:
    a = adjust_block(noisy.started_at(best.images.values).block, ap_models.get("brown14"))
    assert a.iterations <= best.iterations
    assert_same_minimum(a, best)


def test_oblique_images(two_camera_world: synthetic.World) -> None:
    """omega of 45 degrees, the field seen from four sides."""
    flight = []
    for heading in synthetic.QUARTERS:
        away = np.array([np.sin(heading), -np.cos(heading), 0.0]) * 1500.0
        for sideways in (-400.0, 400.0):
            along = np.array([np.cos(heading), np.sin(heading), 0.0]) * sideways
            station = away + along + [0.0, 0.0, 1500.0]
            flight.append([*station, *_looking_from(heading)])
    exterior = np.array(flight)
    assert np.rad2deg(np.abs(exterior[:, 3:5])).max() > 40.0
    w = synthetic.world([(synthetic.SWW, exterior)], synthetic.quincunx(spacing_m=250.0))
    noisy = w.with_noise(np.random.default_rng(6))
    a = adjust_block(noisy.block, ap_models.get("optical"))
    b = adjust_block(noisy.started_at(disturbed(exterior, 1, 0.01, 2.0)).block, ap_models.get("optical"))
    assert_same_minimum(b, a)
    assert 0.8 < a.sigma0 < 1.2


def _looking_from(heading: float) -> list[float]:
    """The angles of a camera that looks 45 degrees down, its x axis along the heading."""
    tilt = np.deg2rad(45.0)
    along = np.array([np.cos(heading), np.sin(heading), 0.0])
    ahead = np.array([-np.sin(heading), np.cos(heading), 0.0])
    back = -(np.sin(tilt) * ahead - np.cos(tilt) * np.array([0.0, 0.0, 1.0]))
    r = np.column_stack([along, np.cross(back, along), back])
    return [float(np.arctan2(-r[1, 2], r[2, 2])), float(np.arcsin(r[0, 2])), float(np.arctan2(-r[0, 1], r[0, 0]))]
