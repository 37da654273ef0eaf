"""The same adjustment without any elimination: one design matrix of all observations, and its QR factors.

The columns are scaled to unit length and the factors are orthogonal, so the square of the condition number never
appears: against the same computation in 64-bit mantissas these inverses are good to 3e-14 in units of the standard
deviations, inverted normal equations only to 3e-12, bordered ones of a free network only to 1e-7.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from adjust import Adjustment
from adjust.datum import FreeAdjustment
from adjust.observations.observations import Observations
from simfield.block.block import Floats

SAME = 1e-10
"""agreement with the engine: of redundancy numbers and standardised residuals as they are, of cofactors and effects on
unknowns in units of the standard deviations. The engine reaches 6e-12, for its normal equations square the condition.
"""


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
    """The cofactors and the step from the QR factors of the weighted design matrix."""
    a, v, weight = design(observations, x)
    free = observations.image_points.unknowns.free
    q, inverse_r = factors(np.sqrt(weight)[:, None] * a[:, free])
    inverse = np.zeros((len(x), len(x)))
    inverse[np.ix_(free, free)] = inverse_r @ inverse_r.T
    step = np.zeros(len(x))
    step[free] = -inverse_r @ (q.T @ (np.sqrt(weight) * v))
    return DenseNormals(inverse, step)


def factors(weighted: Floats) -> tuple[Floats, Floats]:
    """Q (q, u) with orthonormal columns and R^-1 (u, u) of a weighted design matrix, so that N^-1 = R^-1 R^-T."""
    scale = np.linalg.norm(weighted, axis=0)
    q, r = np.linalg.qr(weighted / scale)
    return q, np.asarray(scipy.linalg.solve_triangular(r, np.eye(len(r))) / scale[:, None])


def in_block_order(a: Adjustment) -> tuple[Floats, Floats, Floats]:
    """As `design`, the image coordinates in the order of the block: that of Influence."""
    matrix, v, weight = design(a.groups, a.x)
    k2 = 2 * len(a.block.observations)
    place = np.arange(len(v))
    place[(2 * a.groups.image_points.order[:, None] + np.arange(2)).ravel()] = np.arange(k2)
    return matrix[place], v[place], weight[place]


def free_network(a: FreeAdjustment) -> Floats:
    """The cofactors of a free network from their definition: N^-1 in the space of the changes that leave the datum
    points where they are in the mean, unturned and of the same size.
    """
    # the adjustment keeps its groups on minimum control, here all coordinates are free
    matrix, _, weight = design(Observations.of(a.block, a.layout), a.x)
    weighted = np.sqrt(weight)[:, None] * matrix
    scale = np.linalg.norm(weighted, axis=0)
    condition = datum_condition(a) / scale[:, None]
    allowed = np.linalg.qr(condition / np.linalg.norm(condition, axis=0), mode="complete")[0][:, 7:]
    _, inverse_r = factors(weighted / scale @ allowed)
    half = allowed @ inverse_r / scale[:, None]
    return np.asarray(half @ half.T)


def datum_condition(a: FreeAdjustment) -> Floats:
    """(size, 7): changes dx with condition^T dx = 0 neither shift nor turn nor stretch the datum points."""
    at = a.layout.points(a.x)[a.datum_rows]
    at = at - at.mean(axis=0)
    condition = np.zeros((len(a.x), 7))
    for row, (x, y, z) in zip(a.datum_rows, at / np.abs(at).max(), strict=True):
        start = a.layout.orientation + 3 * row
        condition[start] = [1.0, 0.0, 0.0, 0.0, z, -y, x]
        condition[start + 1] = [0.0, 1.0, 0.0, -z, 0.0, x, y]
        condition[start + 2] = [0.0, 0.0, 1.0, y, -x, 0.0, z]
    return condition
