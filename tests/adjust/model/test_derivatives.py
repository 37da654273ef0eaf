"""Every analytic derivative against a numerical one."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from adjust import ap_models
from adjust.model.collinearity import linearise, project
from adjust.model.rotation import rotation_derivatives, rotation_matrices
from adjust.model.unknowns import Unknowns
from adjust.observations.observations import Observations
from adjust.solution import initial
from simfield.block.block import Floats
from tests import synthetic
from tests.adjust import dense

# Central differences of second order with relative steps near eps^(1/3) are good to about eps^(2/3) = 4e-11 of the size
# of the function over that of its change; two digits of reserve.
DERIVATIVE_TOLERANCE = 5e-9

ATTITUDES_DEG = [
    (0.0, 0.0, 0.0),
    (1.5, -2.0, 45.0),
    (-3.0, 2.0, 179.9999),
    (2.0, 1.0, -180.0),
    (0.5, 4.0, 180.0001),
    (44.0, 10.0, 120.0),
    (-61.0, -35.0, 268.0),
    (15.0, 80.0, -90.0),
]
INTERIOR = np.array([[152.9, 0.3, -0.2]])


def numerical(f: Callable[[Floats], Floats], at: Floats, steps: Floats) -> Floats:
    """Central differences of f (..., q) by every element of at; the last axis of the answer is that of at."""
    columns = []
    for i, step in enumerate(steps):
        there, back = at.copy(), at.copy()
        there[i] += step
        back[i] -= step
        columns.append((f(there) - f(back)) / (there[i] - back[i]))
    return np.stack(columns, axis=-1)


def assert_same(analytic: Floats, by_differences: Floats) -> None:
    scale = np.abs(by_differences).max(axis=tuple(range(by_differences.ndim - 1)))
    worst = np.abs(analytic - by_differences).max(axis=tuple(range(by_differences.ndim - 1)))
    assert (worst <= DERIVATIVE_TOLERANCE * np.where(scale > 0.0, scale, 1.0)).all(), worst / scale


def looking_at(attitude_deg: tuple[float, float, float]) -> tuple[Floats, Floats]:
    """An exterior orientation of that attitude, and points spread over its field of view."""
    rng = np.random.default_rng(11)
    angles = np.deg2rad(attitude_deg)
    direction = np.column_stack([rng.uniform(-0.7, 0.7, (12, 2)), -np.ones(12)]) * rng.uniform(900.0, 1800.0, (12, 1))
    station = np.array([4100.0, -2300.0, 1650.0])
    return np.concatenate([station, angles]), station + direction @ rotation_matrices(angles[None])[0].T


@pytest.mark.parametrize("attitude", ATTITUDES_DEG)
class TestCollinearity:
    def test_exterior(self, attitude: tuple[float, float, float]) -> None:
        exterior, points = looking_at(attitude)
        image = np.zeros(len(points), dtype=int)
        steps = np.array([0.01, 0.01, 0.01, 1e-5, 1e-5, 1e-5])
        by_differences = numerical(lambda e: project(e[None], INTERIOR, points, image)[0], exterior, steps)
        assert_same(linearise(exterior[None], INTERIOR, points, image).by_exterior, by_differences)

    def test_point(self, attitude: tuple[float, float, float]) -> None:
        exterior, points = looking_at(attitude)
        image = np.zeros(len(points), dtype=int)
        at = linearise(exterior[None], INTERIOR, points, image)
        by_differences = numerical(
            lambda shift: project(exterior[None], INTERIOR, points + shift, image)[0], np.zeros(3), np.full(3, 0.01)
        )
        assert_same(at.by_point, by_differences)

    def test_interior(self, attitude: tuple[float, float, float]) -> None:
        exterior, points = looking_at(attitude)
        image = np.zeros(len(points), dtype=int)
        at = linearise(exterior[None], INTERIOR, points, image)
        by_differences = numerical(
            lambda i: project(exterior[None], i[None], points, image)[0], INTERIOR[0], np.full(3, 1e-3)
        )
        assert_same(at.by_interior, by_differences)

    def test_the_linearised_projection_is_the_projection(self, attitude: tuple[float, float, float]) -> None:
        exterior, points = looking_at(attitude)
        image = np.zeros(len(points), dtype=int)
        xy, depth = project(exterior[None], INTERIOR, points, image)
        at = linearise(exterior[None], INTERIOR, points, image)
        np.testing.assert_array_equal(at.xy, xy)
        np.testing.assert_array_equal(at.depth, depth)
        assert (depth > 0.0).all()

    def test_rotation(self, attitude: tuple[float, float, float]) -> None:
        angles = np.deg2rad(attitude)
        matrix, derivatives = rotation_derivatives(angles[None])
        by_differences = numerical(lambda a: rotation_matrices(a[None])[0], angles, np.full(3, 1e-5))
        assert_same(derivatives[:, 0].transpose(1, 2, 0), by_differences)
        np.testing.assert_allclose(matrix[0] @ matrix[0].T, np.eye(3), atol=1e-15)

    def test_rotation_is_that_of_the_textbook(self, attitude: tuple[float, float, float]) -> None:
        angles = np.deg2rad(attitude)
        np.testing.assert_allclose(rotation_matrices(angles[None])[0], synthetic.rotation(*angles), atol=1e-15)


def test_a_point_in_the_plane_of_the_projection_centre_has_no_image_and_makes_no_noise() -> None:
    exterior = np.array([[0.0, 0.0, 100.0, 0.0, 0.0, 0.0]])
    points = np.array([[1.0, 2.0, 100.0], [0.0, 0.0, 100.0]])
    xy, depth = project(exterior, INTERIOR, points, np.zeros(2, dtype=int))
    assert not np.isfinite(xy).any()
    np.testing.assert_array_equal(depth, 0.0)


@pytest.mark.parametrize("model", ["none", "optical", "torlegard", "brown14"])
def test_the_whole_design_matrix(two_camera_world: synthetic.World, model: str) -> None:
    """Columns of images, additional parameters of both cameras, points and weighted control, away from the minimum."""
    w = two_camera_world.controlled(synthetic.CONTROL, (0.01, 0.0, 0.02))
    unknowns = Unknowns.of(w.block, ap_models.get(model))
    observations = Observations.of(w.block, unknowns)
    rng = np.random.default_rng(5)
    x = initial.values(unknowns, observations.image_points)
    images = 6 * len(w.block.images)
    step = np.full(len(x), 0.01)
    step[:images].reshape(-1, 6)[:, 3:] = 1e-5
    spread = np.where(unknowns.free, 100.0 * step, 0.0)
    basis = observations.image_points.basis
    for s in unknowns.sets:
        mine = unknowns.image_set[observations.image_points.image] == unknowns.sets.index(s)
        largest = np.abs(basis[mine]).max(axis=(0, 1))[: len(s.model.parameters)]
        step[s.columns] = 0.1 / largest
        spread[s.columns] = 0.02 / largest
    x = x + spread * rng.uniform(-1.0, 1.0, len(x))

    def residuals(there: Floats) -> Floats:
        v, _ = observations.image_points.residuals(there)
        return np.concatenate([v.ravel(), observations.control.residuals(there)])

    a, v, _ = dense.design(observations, x)
    np.testing.assert_array_equal(v, residuals(x))
    free = np.flatnonzero(unknowns.free)
    chosen = np.unique(np.r_[free[free < unknowns.orientation], rng.choice(free[free >= unknowns.orientation], 60)])

    def of_chosen(part: Floats) -> Floats:
        there = x.copy()
        there[chosen] = part
        return residuals(there)

    assert_same(a[:, chosen], numerical(of_chosen, x[chosen], step[chosen]))
