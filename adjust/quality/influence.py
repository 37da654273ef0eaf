"""How observations act on each other: R = I - A Q A^T P, row by row, without ever forming it.

In units of their standard deviations the observations have the design matrix a = P^(1/2) A, the hat matrix h = a Q a^T
and the redundancy matrix r = I - h, both symmetric. With the points eliminated (adjust.normals.normals),

    h_ij = t_i . t_j + (b_i . b_j where i and j see the same point),   t = (a_e - a_p Z) Q_ee^(1/2),   b = a_p V^(-1/2),

so that every entry costs one product of short vectors. h_ii is the share of an observation that the unknowns take up,
r_ii its redundancy number (Baarda 1968; Foerstner 1979), and the sum of all r_ii is the redundancy.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.linalg

from adjust.adjustment import Adjustment
from adjust.model import POINT_NAMES
from adjust.normals import FactorisedNormals, Plain
from adjust.observations import Observations
from simfield.block import Floats, Indices

NOTHING_LEFT = 1e-9
"""redundancy numbers below this are rounding: such an observation is checked by nothing"""


@dataclass(frozen=True, eq=False)
class Rows:
    """All n observations, image coordinates in the order of the block (x, y, x, y, ...), then control, then further
    groups.

    v (n) corrections in their own units, weight (n); point (n) the eliminated point that a row sees, or -1.
    """

    v: Floats
    weight: Floats
    point: Indices

    @property
    def standard(self) -> Floats:
        """(n) the corrections in units of their observations' a priori standard deviations."""
        return np.asarray(np.sqrt(self.weight) * self.v)


@dataclass(frozen=True, eq=False)
class Influence:
    """The hat matrix of an adjustment in factors: t (n, E), b (n, 3), and what was observed.

    Holds n (E + 3) numbers: 14 MB for 6626 observations of 39 images.
    """

    adjustment: Adjustment
    factor: FactorisedNormals
    rows: Rows
    t: Floats
    b: Floats

    @classmethod
    def of(cls, adjustment: Adjustment) -> Influence:
        """Raises ValueError where the adjustment failed."""
        a = adjustment.regular
        factor, size = _dense_factor(a), a.layout.orientation
        groups = a.groups
        control = groups.control
        k2 = 2 * len(groups.image_points.image)
        by_orientation, by_point, v = _image_rows(a)
        count = groups.rows
        reduced, right = np.zeros((count, size)), np.zeros((count, 3))
        weight = np.empty(count)
        point = np.full(count, -1, dtype=np.intp)
        order = (2 * groups.image_points.order[:, None] + np.arange(2)).ravel()
        point[order] = np.repeat(groups.image_points.point, 2)
        weight[order] = groups.image_points.weight.ravel()
        reduced[order], right[order] = by_orientation, by_point
        q = k2 + len(control.columns)
        weight[k2:q] = control.weight
        _fill_control(groups, a.layout.orientation, reduced[k2:q], right[k2:q], point[k2:q])
        values = np.empty(count)
        values[order], values[k2:q] = v, control.residuals(a.x)
        for group in groups.further:
            at, rows = group.at(a.x), np.arange(q, q + len(group.weight))
            np.add.at(reduced, (rows[:, None], at.columns), at.values)
            weight[rows], values[rows], q = group.weight, at.v, q + len(rows)
        inside = point >= 0
        right[inside] = (right[inside][:, None, :] @ factor.root[point[inside]].transpose(0, 2, 1))[:, 0]
        _subtract_hanging(reduced, right, point, factor.white)
        root = np.sqrt(weight)[:, None]
        reduced *= root * factor.scale
        t = scipy.linalg.solve_triangular(factor.lower, reduced.T, lower=True, check_finite=False, overwrite_b=True).T
        return cls(a, factor, Rows(values, weight, point), t, right * root)

    def __len__(self) -> int:
        return len(self.rows.v)

    @cached_property
    def leverage(self) -> Floats:
        """(n) the diagonal of h."""
        return np.asarray(np.einsum("ij,ij->i", self.t, self.t) + np.einsum("ij,ij->i", self.b, self.b))

    @cached_property
    def redundancy(self) -> Floats:
        """(n) the redundancy numbers r_ii; 1 where the weight is 0, for nothing depends on such an observation."""
        return np.where(1.0 - self.leverage > NOTHING_LEFT, 1.0 - self.leverage, 0.0)

    def hat(self, i: Indices, j: Indices) -> Floats:
        """h[i, j] (len(i), len(j))."""
        same = (self.rows.point[i][:, None] == self.rows.point[j]) & (self.rows.point[i] >= 0)[:, None]
        return np.asarray(self.t[i] @ self.t[j].T + np.where(same, self.b[i] @ self.b[j].T, 0.0))

    def column(self, j: int) -> Floats:
        """(n) the column r[:, j] of the redundancy matrix."""
        column = -(self.t @ self.t[j])
        if self.rows.point[j] >= 0:
            same = np.flatnonzero(self.rows.point == self.rows.point[j])
            column[same] -= self.b[same] @ self.b[j]
        column[j] += 1.0
        return np.asarray(column)

    def effect(self, i: Indices, at: Indices) -> Floats:
        """(len(i), len(at)): the change of the unknowns `at` (places in x) by an error of one standard deviation in
        i.
        """
        a, factor = self.adjustment, self.factor
        size = a.layout.orientation
        # t D L^T = reduced row, so that Q_ee (a_e - a_p Z)^T = D L^-T t
        step = scipy.linalg.solve_triangular(factor.lower, self.t[i].T, lower=True, trans=1, check_finite=False).T
        by_orientation = step * factor.scale
        effect = by_orientation @ factor.spread(at).T
        inside = np.flatnonzero(at >= size)
        point, axis = np.divmod(at[inside] - size, 3)
        seen = self.rows.point[i]
        for row in np.flatnonzero(seen >= 0):
            mine = inside[point == seen[row]]
            effect[row, mine] += (self.b[i[row]] @ factor.root[seen[row]])[axis[point == seen[row]]]
        effect[:, ~a.layout.free[at]] = 0.0
        return np.asarray(effect)


def row_name(groups: Observations, row: int) -> str:
    """The observation of a row in words, such as "y of point 33 in image ww-2" or "Z of control point 11"."""
    points, control = groups.image_points, groups.control
    block, k2 = points.unknowns.block, 2 * len(points.image)
    if row < k2:
        o = block.observations
        point, image = block.points.ids[o.point[row // 2]], block.images.ids[o.image[row // 2]]
        return f"{'xy'[row % 2]} of point {point} in image {image}"
    if row >= k2 + len(control.columns):
        labels = [label for group in groups.further for label in group.labels]
        return labels[row - k2 - len(control.columns)]
    at, axis = np.divmod(int(control.coordinates[row - k2]), 3)
    return f"{POINT_NAMES[axis]} of control point {block.points.ids[at]}"


def _image_rows(a: Adjustment) -> tuple[Floats, Floats, Floats]:
    """By orientation (2k, E), by point (2k, 3), and v (2k), in the order of the group."""
    g, u = a.groups.image_points, a.layout
    at = g.jacobian(a.x)
    k = len(g.image)
    by_orientation = np.zeros((k, 2, u.orientation))
    for image in range(len(u.block.images)):
        rows = slice(g.starts[image], g.starts[image + 1])
        columns = u.sets[u.image_set[image]].columns
        by_orientation[rows, :, 6 * image : 6 * image + 6] = at.by_orientation[rows, :, :6]
        by_orientation[rows, :, columns] = at.by_orientation[rows, :, 6 : 6 + columns.stop - columns.start]
    if len(u.coupled):
        tied, form = g.coupled(a.x)
        by_orientation[tied] = 0.0
        here = (2 * tied[:, None] + np.arange(2)).ravel()
        np.add.at(by_orientation.reshape(2 * k, -1), (here[:, None], form.columns), form.values)
    return by_orientation.reshape(2 * k, -1), at.by_point.reshape(2 * k, 3), at.v.ravel()


def _fill_control(groups: Observations, size: int, reduced: Floats, right: Floats, point: Indices) -> None:
    for row, column in enumerate(groups.control.columns):
        if column < size:
            reduced[row, column] = 1.0
        else:
            point[row], axis = np.divmod(column - size, 3)
            right[row, axis] = 1.0


def _subtract_hanging(reduced: Floats, right: Floats, point: Indices, white: Floats) -> None:
    """Subtract a_p Z from the rows, those of a point together; right (n, 3) is a_p V^(-1/2), point -1 has none."""
    order = np.argsort(point, kind="stable")
    bounds = np.searchsorted(point[order], np.arange(len(white) + 1))
    for p, (start, stop) in enumerate(pairwise(bounds)):
        rows = order[start:stop]
        reduced[rows] -= right[rows] @ white[p]


def _dense_factor(a: Adjustment) -> FactorisedNormals:
    """The factorised normal equations with a dense reduced matrix, also where the adjustment needed only a band."""
    factor = a.cofactors.factor
    return factor if isinstance(factor, FactorisedNormals) else Plain(a.groups).factorise(Plain(a.groups).at(a.x))
