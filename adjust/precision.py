"""Cofactors of the unknowns: any block of Q = N^-1, always marginal, never conditional on other unknowns.

With Q_ee = S^-1 and Z = V^-1 W:  Q_pe = -Z Q_ee,  Q_pp = V^-1 + Z Q_ee Z^T.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from adjust.band_factor import BandFactor
from adjust.band_inverse import band_cofactors
from adjust.normals import Factor
from adjust.unknowns import Unknowns
from simfield.block import Floats, Indices


@dataclass(frozen=True, eq=False)
class Cofactors:
    """The cofactor matrix of all unknowns, computed where it is asked for."""

    unknowns: Unknowns
    factor: Factor | BandFactor

    @cached_property
    def orientation(self) -> Floats:
        """Q_ee (E, E), dense. Of a block of thousands of images this is gigabytes; `diagonal` and `block` are not."""
        if isinstance(self.factor, BandFactor):
            return self.factor.solve_orientation(np.eye(self.unknowns.orientation))
        inverse, _ = scipy.linalg.lapack.dpotri(self.factor.lower, lower=1)
        full = np.tril(inverse) + np.tril(inverse, -1).T
        return np.asarray(full * self.factor.scale * self.factor.scale[:, None])

    @cached_property
    def _parts(self) -> tuple[Floats, Floats]:
        """The diagonal of Q_ee (E) and the blocks (n, 3, 3) of Q_pp."""
        if isinstance(self.factor, BandFactor):
            diagonal, blocks = band_cofactors(self.factor)
        else:
            white, root = self.factor.white, self.factor.root
            diagonal = np.diag(self.orientation)
            spread = (white.reshape(-1, len(diagonal)) @ self.orientation).reshape(white.shape)
            blocks = root.transpose(0, 2, 1) @ (np.eye(3) + spread @ white.transpose(0, 2, 1)) @ root
        fixed = self.unknowns.held
        blocks[fixed[:, :, None] | fixed[:, None, :]] = 0.0
        return diagonal, np.asarray(blocks)

    @property
    def points(self) -> Floats:
        """(n, 3, 3) the blocks of Q_pp, zero for coordinates held fixed."""
        return self._parts[1]

    @cached_property
    def diagonal(self) -> Floats:
        """The cofactor of every unknown in the layout of x."""
        return np.concatenate([self._parts[0], np.einsum("nii->ni", self.points).ravel()])

    def block(self, rows: Indices, columns: Indices) -> Floats:
        """Q[rows, columns] for any places in x."""
        left, right = self.factor.spread(rows), self.factor.spread(columns)
        if isinstance(self.factor, BandFactor):
            q = left @ self.factor.solve_orientation(np.ascontiguousarray(right.T))
        else:
            q = left @ self.orientation @ right.T
        size = self.unknowns.orientation
        row_point, column_point = (rows - size) // 3, (columns - size) // 3
        same = (rows >= size)[:, None] & (columns >= size) & (row_point[:, None] == column_point)
        i, j = np.nonzero(same)
        root = self.factor.root
        q[i, j] += np.einsum(
            "kq,kq->k", root[row_point[i], :, (rows[i] - size) % 3], root[row_point[i], :, (columns[j] - size) % 3]
        )
        q[~self.unknowns.free[rows]] = 0.0
        q[:, ~self.unknowns.free[columns]] = 0.0
        return np.asarray(q)
