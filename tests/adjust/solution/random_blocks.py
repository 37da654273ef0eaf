"""Small random blocks, and a dense least squares of them that shares nothing with the product: its own projection, its
own derivatives, rotations as vectors on the true ones, scipy's trust region.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from simfield.block import Block, Camera, Floats, ImageObservations, Images, Points

KINDS = ("vertical", "oblique", "level", "long lens")
STARTS = ("true", "rough", "none")
SINGULAR = 1e-7
"""least singular value of the design matrix with columns of unit length; normal equations see its square"""


@dataclass(frozen=True, eq=False)
class Case:
    """A block, how it was made, and the truth: stations (m, 3), axes (m, 3, 3) and points (n, 3)."""

    kind: str
    start: str
    block: Block
    stations: Floats
    axes: Floats
    points: Floats


def case(seed: int) -> Case | None:
    """2 to 8 images of 8 to 24 points, 3 to 6 of them control; None where a point or an image is seen too little."""
    g = np.random.default_rng(seed)
    kind, start = str(g.choice(KINDS)), str(g.choice(STARTS))
    m, n, control = int(g.integers(2, 9)), int(g.integers(8, 25)), int(g.integers(3, 7))
    c = 600.0 if kind == "long lens" else 100.0
    stations, axes = _flown(g, kind, m)
    flat = kind in ("vertical", "oblique")
    reach = np.array([150.0, 120.0, 0.0]) if flat else np.array([100.0, 100.0, 60.0])
    points = g.uniform(-1.0, 1.0, (n, 3)) * reach + np.array([0.0, 0.0, g.choice([2.0, 40.0]) * flat]) * g.normal(
        size=(n, 1)
    )
    p = np.einsum("mji,mnj->mni", axes, points[None] - stations[:, None])
    with np.errstate(all="ignore"):
        xy = -c * p[..., :2] / p[..., 2:]
    image, point = np.nonzero((p[..., 2] < 0.0) & (np.abs(xy) < 100.0).all(axis=2))
    rays = np.bincount(point, minlength=n)
    if (rays[control:] < 2).any() or np.bincount(image, minlength=m).min() < 4:
        return None
    sigma, noise = 0.005, float(g.choice([0.005, 0.05]))
    measured = xy[image, point] + noise * g.normal(size=(len(image), 2))
    given_sigma = float(g.choice([0.0, 0.02]))
    is_control = np.arange(n) < control
    exterior = np.hstack([stations, _angles(axes)])
    if start == "rough":
        exterior += g.normal(size=(m, 6)) * np.repeat([10.0, np.deg2rad(2.0)], 3)
    block = Block(
        (Camera("c", c, 0.0, 0.0, 200.0, 200.0),),
        Images(
            tuple(f"i{i}" for i in range(m)),
            np.zeros(m, dtype=np.intp),
            exterior if start != "none" else np.full((m, 6), np.nan),
        ),
        Points(
            tuple(f"p{i}" for i in range(n)),
            np.where(is_control, "control", "tie"),
            np.where(is_control[:, None], points + given_sigma * g.normal(size=(n, 3)), np.nan),
            np.where(is_control[:, None], given_sigma, np.nan) * np.ones((n, 3)),
        ),
        ImageObservations(image, point, measured, np.full((len(image), 2), sigma)),
    )  # fmt: skip
    return Case(kind, start, block, stations, axes, points)


def _flown(g: np.random.Generator, kind: str, m: int) -> tuple[Floats, Floats]:
    if kind == "vertical":
        stations = np.column_stack([g.uniform(-120, 120, m), g.uniform(-80, 80, m), 500 + g.normal(0, 10, m)])
        back = np.column_stack([0.03 * g.normal(size=(m, 2)), np.ones(m)])
    elif kind == "oblique":
        azimuth, tilt = g.uniform(0, 2 * np.pi, m), np.deg2rad(g.uniform(20, 60, m))
        back = np.column_stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
        stations = 500.0 * back + g.normal(0, 10, (m, 3))
    else:
        azimuth = 0.5 * np.pi * g.integers(0, 4, m) + g.choice([0.0, 1.0]) * g.uniform(0, 1.5, m)
        back = np.column_stack([np.cos(azimuth), np.sin(azimuth), np.zeros(m)])
        stations = (3000.0 if kind == "long lens" else 500.0) * back + g.normal(0, 20, (m, 3))
    back /= np.linalg.norm(back, axis=1, keepdims=True)
    right = np.cross(g.normal(size=(m, 3)) if kind in ("vertical", "oblique") else [0.0, 0.0, 1.0], back)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    return stations, np.stack([right, np.cross(back, right), back], axis=2)


def _angles(axes: Floats) -> Floats:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # at the gimbal scipy says that it sets an angle to zero
        return np.asarray(Rotation.from_matrix(axes).as_euler("XYZ"))


@dataclass(frozen=True, eq=False)
class Dense:
    """The corrections of a case over their standard deviations, and their derivatives, at stations (m, 3), small
    rotations (m, 3) on given axes (m, 3, 3), and points (n, 3).
    """

    case: Case

    def minimum(self) -> tuple[float, float]:
        """vPv at the minimum that scipy finds from the truth, and the least singular value of the design there."""
        block = self.case.block
        m, free = len(block.images), ~block.points.fixed
        start = np.concatenate([self.case.stations.ravel(), np.zeros(3 * m), self.case.points[free]])

        def at(x: Floats) -> tuple[Floats, Floats]:
            turned = Rotation.from_rotvec(x[3 * m : 6 * m].reshape(m, 3)).as_matrix() @ self.case.axes
            return self.evaluated(x[: 3 * m].reshape(m, 3), turned, self._points(x[6 * m :]))

        def numerical(x: Floats) -> Floats:
            # the derivatives by the rotation vector itself: those of small rotations after it, times its own
            _, jacobian = at(x)
            for i in range(m):
                columns = slice(3 * m + 3 * i, 3 * m + 3 * i + 3)
                jacobian[:, columns] = jacobian[:, columns] @ _left_jacobian(x[columns])
            return jacobian

        done = least_squares(
            lambda x: at(x)[0], start, numerical, x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=500
        )
        jacobian = done.jac / np.linalg.norm(done.jac, axis=0)
        return 2.0 * float(done.cost), float(np.linalg.svd(jacobian, compute_uv=False)[-1])

    def distance(self, exterior: Floats, points: Floats) -> float:
        """How far a solution is from a place where the gradient vanishes, in standard deviations."""
        axes = Rotation.from_euler("XYZ", exterior[:, 3:]).as_matrix()
        v, jacobian = self.evaluated(exterior[:, :3], axes, points)
        scale = np.linalg.norm(jacobian, axis=0)
        q, _ = np.linalg.qr(jacobian / scale)
        return float(np.linalg.norm(q.T @ v))

    def _points(self, free: Floats) -> Floats:
        p = self.case.block.points
        points = p.coordinates.copy()
        points[~p.fixed] = free
        return points

    def evaluated(self, stations: Floats, axes: Floats, points: Floats) -> tuple[Floats, Floats]:
        """v (q) and its derivatives (q, u)."""
        block = self.case.block
        o, p, c, m = block.observations, block.points, block.cameras[0].c_mm, len(block.images)
        ray = points[o.point] - stations[o.image]
        turn = axes[o.image].transpose(0, 2, 1)
        seen = np.einsum("kij,kj->ki", turn, ray)
        ratio = seen[:, :2] / seen[:, 2:]
        v = (-c * ratio - o.xy) / o.sigma
        by_seen = np.zeros((len(ray), 2, 3))
        by_seen[:, 0, 0] = by_seen[:, 1, 1] = -c / seen[:, 2]
        by_seen[:, :, 2] = c * ratio / seen[:, 2:]
        by_point = by_seen @ turn / o.sigma[:, :, None]
        cross = np.zeros((len(ray), 3, 3))
        for axis in range(3):
            cross[:, :, axis] = -np.cross(np.eye(3)[axis], ray)
        by_turn = by_point @ cross
        jacobian = np.zeros((2 * len(ray), 6 * m + points.size))
        for k, (i, j) in enumerate(zip(o.image, o.point, strict=True)):
            rows = slice(2 * k, 2 * k + 2)
            jacobian[rows, 3 * i : 3 * i + 3] = -by_point[k]
            jacobian[rows, 3 * m + 3 * i : 3 * m + 3 * i + 3] = by_turn[k]
            jacobian[rows, 6 * m + 3 * j : 6 * m + 3 * j + 3] = by_point[k]
        held = p.weighted
        more = np.zeros((int(held.sum()), jacobian.shape[1]))
        more[np.arange(len(more)), 6 * m + np.flatnonzero(held)] = 1.0 / p.sigma[held]
        kept = np.concatenate([np.ones(6 * m, dtype=bool), ~p.fixed.ravel()])
        corrections = np.concatenate([v.ravel(), (points - p.coordinates)[held] / p.sigma[held]])
        return corrections, np.vstack([jacobian, more])[:, kept]


def _left_jacobian(w: Floats) -> Floats:
    """(3, 3): exp(w + dw) = exp(J dw) exp(w)."""
    angle = float(np.linalg.norm(w))
    k = np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])
    if angle < 1e-6:
        return np.eye(3) + 0.5 * k + k @ k / 6.0
    return np.asarray(np.eye(3) + (1 - np.cos(angle)) / angle**2 * k + (angle - np.sin(angle)) / angle**3 * k @ k)
