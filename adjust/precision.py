"""Cofactors of the unknowns: any block of Q = N^-1, always marginal, never conditional on other unknowns.

With Q_ee = S^-1 and Z = V^-1 W:  Q_pe = -Z Q_ee,  Q_pp = V^-1 + Z Q_ee Z^T.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from adjust.normals import Factor
from adjust.unknowns import Unknowns
from simfield.block import Floats, Indices


@dataclass(frozen=True, eq=False)
class Cofactors:
    """The cofactor matrix of all unknowns, computed where it is asked for."""

    unknowns: Unknowns
    factor: Factor

    @cached_property
    def orientation(self) -> Floats:
        """Q_ee (E, E)."""
        inverse, _ = scipy.linalg.lapack.dpotri(self.factor.lower, lower=1)
        full = np.tril(inverse) + np.tril(inverse, -1).T
        return np.asarray(full * self.factor.scale * self.factor.scale[:, None])

    @cached_property
    def points(self) -> Floats:
        """(n, 3, 3) the blocks of Q_pp, zero for coordinates held fixed."""
        z = self.factor.eliminated
        blocks = self.factor.point_inverse + (z @ self.orientation) @ z.transpose(0, 2, 1)
        fixed = self.unknowns.block.points.fixed
        blocks[fixed[:, :, None] | fixed[:, None, :]] = 0.0
        return np.asarray(blocks)

    @cached_property
    def diagonal(self) -> Floats:
        """The cofactor of every unknown in the layout of x."""
        return np.concatenate([np.diag(self.orientation), np.einsum("nii->ni", self.points).ravel()])

    def block(self, rows: Indices, columns: Indices) -> Floats:
        """Q[rows, columns] for any places in x."""
        left, right = self._spread(rows), self._spread(columns)
        q = left @ self.orientation @ right.T
        size = self.unknowns.orientation
        row_point, column_point = (rows - size) // 3, (columns - size) // 3
        same = (rows >= size)[:, None] & (columns >= size) & (row_point[:, None] == column_point)
        i, j = np.nonzero(same)
        q[i, j] += self.factor.point_inverse[row_point[i], (rows[i] - size) % 3, (columns[j] - size) % 3]
        q[~self.unknowns.free[rows]] = 0.0
        q[:, ~self.unknowns.free[columns]] = 0.0
        return np.asarray(q)

    def _spread(self, at: Indices) -> Floats:
        """(len(at), E): the rows of [I; -Z], by which every unknown hangs on the orientation unknowns."""
        size = self.unknowns.orientation
        rows = np.zeros((len(at), size))
        inside = np.flatnonzero(at < size)
        rows[inside, at[inside]] = 1.0
        outside = np.flatnonzero(at >= size)
        rows[outside] = -self.factor.eliminated.reshape(-1, size)[at[outside] - size]
        return rows
