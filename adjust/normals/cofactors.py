"""Cofactors of the unknowns: any block of Q = N^-1, always marginal, never conditional on other unknowns.

With Q_ee = S^-1 and Z = V^-1 W:  Q_pe = -Z Q_ee,  Q_pp = V^-1 + Z Q_ee Z^T.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg

from adjust.model import Unknowns
from adjust.normals.band import BandFactor
from adjust.normals.band_inverse_compiled import band_cofactors
from adjust.normals.normals import FactorisedNormals
from simfield.block import Floats, Indices
from simfield.numerics import one_thread

TRIANGLE_LEAST = 32
"""rows of a triangular matrix that is not halved any more"""


@dataclass(frozen=True, eq=False)
class Cofactors:
    """The cofactor matrix of all unknowns, computed where it is asked for."""

    unknowns: Unknowns
    factor: FactorisedNormals | BandFactor

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
            diagonal, blocks = _dense_cofactors(self.factor)
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
        with one_thread():
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


def _dense_cofactors(factor: FactorisedNormals) -> tuple[Floats, Floats]:
    """The diagonal of Q_ee (E) and the blocks (n, 3, 3) of Q_pp, by L^-1 alone: half the work of S^-1.

    With S^-1 = D L^-T L^-1 D and X = L^-1 D white^T:  q_ii = d_i^2 |column i of L^-1|^2,  Q_pp = R^T (I + X^T X) R.
    """
    inverse = _inverse_of_lower(factor.lower)
    diagonal = factor.scale**2 * np.einsum("ij,ij->j", inverse, inverse)
    scaled = factor.white.reshape(-1, len(diagonal)) * factor.scale
    spread = scipy.linalg.blas.dtrmm(1.0, inverse, scaled.T, lower=1, overwrite_b=1).T.reshape(factor.white.shape)
    root = factor.root
    crossed = np.einsum("nie,nje->nij", spread, spread)
    return diagonal, root.transpose(0, 2, 1) @ (np.eye(3) + crossed) @ root


def _inverse_of_lower(lower: Floats) -> Floats:
    """The inverse of a lower triangular matrix, by halves: [A 0; B C]^-1 = [A^-1 0; -C^-1 B A^-1 C^-1].

    Nearly all of it are products of matrices; LAPACK alone takes three times as long at a few hundred rows.
    """
    half = len(lower) // 2
    if half < TRIANGLE_LEAST:
        return np.asarray(scipy.linalg.lapack.dtrtri(lower, lower=1)[0])
    inverse = np.zeros_like(lower, order="F")
    inverse[:half, :half] = a = _inverse_of_lower(lower[:half, :half])
    inverse[half:, half:] = c = _inverse_of_lower(lower[half:, half:])
    inverse[half:, :half] = -c @ (lower[half:, :half] @ a)
    return inverse
