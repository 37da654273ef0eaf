"""The same adjustment without any elimination: one design matrix of all observations, and its full normal equations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust.observations import Observations
from simfield.block import Floats


@dataclass(frozen=True)
class DenseNormals:
    """N^-1 and the step -N^-1 A^T P v in the layout of x; coordinates held fixed have no variance and no step."""

    inverse: Floats
    step: Floats


def design(observations: Observations, x: Floats) -> tuple[Floats, Floats, Floats]:
    """A (q, size), v (q) and the weights (q): image coordinates first, then weighted control, then further groups."""
    group, control = observations.image_points, observations.control
    u = group.unknowns
    at = group.jacobian(x)
    rows = 2 * len(group.image)
    a = np.zeros((observations.rows, len(x)))
    for i, (image, point) in enumerate(zip(group.image, group.point, strict=True)):
        ap = u.sets[u.image_set[image]].columns
        two = slice(2 * i, 2 * i + 2)
        a[two, 6 * image : 6 * image + 6] = at.by_orientation[i, :, :6]
        a[two, ap] = at.by_orientation[i, :, 6 : 6 + ap.stop - ap.start]
        a[two, u.orientation + 3 * point : u.orientation + 3 * point + 3] = at.by_point[i]
    for i, column in enumerate(control.columns):
        a[rows + i, column] = 1.0
    v = [at.v.ravel(), control.residuals(x)]
    weight = [group.weight.ravel(), control.weight]
    start = rows + len(control.columns)
    for further in observations.further:
        linear = further.at(x)
        for row, (columns, values) in enumerate(zip(linear.columns, linear.values, strict=True), start=start):
            for column, value in zip(columns, values, strict=True):
                a[row, column] += value
        v.append(linear.v)
        weight.append(further.weight)
        start += len(linear.v)
    return a, np.concatenate(v), np.concatenate(weight)


def solve(observations: Observations, x: Floats) -> DenseNormals:
    """The full normal equations, columns scaled to a unit diagonal before the inversion."""
    a, v, weight = design(observations, x)
    free = observations.image_points.unknowns.free
    normal = (a[:, free].T * weight) @ a[:, free]
    scale = 1.0 / np.sqrt(np.diag(normal))
    reduced = np.linalg.inv(normal * scale * scale[:, None]) * scale * scale[:, None]
    inverse = np.zeros((len(x), len(x)))
    inverse[np.ix_(free, free)] = reduced
    step = np.zeros(len(x))
    step[free] = -reduced @ (a[:, free].T @ (weight * v))
    return DenseNormals(inverse, step)
