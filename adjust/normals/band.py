"""Factorised normal equations of a large block: a band of images, bordered by the additional parameters.

With the reduced matrix [[B, C], [C^T, D]], B banded: B = L L^T, U = L^-1 C, and D - U^T U is small and dense.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.linalg

from adjust.normals import loops_compiled as loops
from adjust.normals.normals import CONDITION_LEAST, inverse_norm
from simfield.block import Floats, Indices


@dataclass(frozen=True, eq=False)
class BandFactor:
    """The factors of a bordered band.

    scale (6m + A) in the order of x; band: Cholesky factor of the scaled B in LAPACK's lower band form; border (6m, A)
    the scaled C and solved (6m, A) = B^-1 C; corner (A, A): Cholesky factor of what is left of D; order (6m): the place
    in the band of every exterior unknown; root (n, 3, 3) = L_V^-1 of every point; white (k, 3, 6), white_a (n, 3, A):
    L_V^-1 W by observations and sets; image, point (k).
    """

    scale: Floats
    band: Floats
    solved: Floats
    border: Floats
    corner: Floats
    order: Indices
    root: Floats
    white: Floats
    white_a: Floats
    image: Indices
    point: Indices
    condition: float
    """the reciprocal condition of the scaled S"""

    def solve_orientation(self, right: Floats) -> Floats:
        """S^-1 right, (E) or (E, q), in the order of x."""
        size = len(self.order)
        scale = self.scale if right.ndim == 1 else self.scale[:, None]
        scaled = right * scale
        top = np.empty_like(scaled[:size])
        top[self.order] = scaled[:size]
        below = scaled[size:] - self.solved.T @ top
        below = scipy.linalg.cho_solve((self.corner, True), below) if below.size else below
        top = scipy.linalg.cho_solve_banded((self.band, True), top - self.border @ below, check_finite=False)
        return np.asarray(np.concatenate([top[self.order], below]) * scale)

    def spread(self, at: Indices) -> Floats:
        """(len(at), E): rows of [I; -V^-1 W], by which the unknowns at these places hang on the orientation."""
        size, images = len(self.scale), len(self.order)
        rows = np.zeros((len(at), size))
        for row, place in zip(rows, at, strict=True):
            if place < size:
                row[place] = 1.0
                continue
            point, axis = divmod(int(place) - size, 3)
            rays = np.flatnonzero(self.point == point)
            hanging = np.einsum("q,kqj->kj", self.root[point, :, axis], self.white[rays])
            row[(6 * self.image[rays][:, None] + np.arange(6)).ravel()] = -hanging.ravel()
            row[images:] = -self.root[point, :, axis] @ self.white_a[point]
        return rows

    def step(self, normals: Any) -> tuple[Floats, float]:
        """The Gauss-Newton step -N^-1 g as one vector, and its length in standard deviations, (g^T N^-1 g)^(1/2)."""
        m6 = len(self.order)
        white_g = np.einsum("nij,nj->ni", self.root, normals.gradient_p)
        reduced = normals.gradient_e.copy()
        by_image = np.einsum("kij,ki->kj", self.white, white_g[self.point])
        for column in range(6):
            reduced[column:m6:6] -= np.bincount(self.image, by_image[:, column], minlength=m6 // 6)
        reduced[m6:] -= np.einsum("nia,ni->a", self.white_a, white_g)
        step_e = -self.solve_orientation(reduced)
        hanging = np.einsum("kij,kj->ki", self.white, step_e[:m6].reshape(-1, 6)[self.image])
        for axis in range(3):
            white_g[:, axis] += np.bincount(self.point, hanging[:, axis], minlength=len(white_g))
        white_g += self.white_a @ step_e[m6:]
        step_p = -np.einsum("nji,nj->ni", self.root, white_g)
        decrement = -float(normals.gradient_e @ step_e + np.sum(normals.gradient_p * step_p))
        return np.concatenate([step_e, step_p.ravel()]), max(decrement, 0.0) ** 0.5


class SingularBandError(ArithmeticError):
    """The banded normal equations are singular; to say why takes the whole matrix."""


def banded(
    normals: Any,
    ordering: Any,
    image_points: Any,
    root: Floats,
    white: Floats,
    white_a: Floats,
    condition_least: float = CONDITION_LEAST,
) -> BandFactor:
    """Reduce to a bordered band and factorise. Raises SingularBandError."""
    g = image_points
    m, a = normals.ea.shape[0], normals.ea.shape[2]
    place = ordering.place
    columns = np.zeros((6 * m, 6 * (ordering.reach + 1)))
    border = np.empty((m, 6, a))
    border[place] = normals.ea
    border = border.reshape(6 * m, a)
    for column in range(6):
        for row in range(column, 6):
            columns[6 * place + column, row - column] = normals.ee[:, row, column]
    loops.reduce_band(ordering.ray_starts, ordering.rays, g.image, place, white, white_a, columns, border)
    flat = white_a.reshape(3 * len(white_a), a)
    corner = normals.aa - flat.T @ flat
    order = (6 * place[:, None] + np.arange(6)).ravel()
    diagonal = np.concatenate([np.einsum("mii->mi", normals.ee).ravel(), np.diag(normals.aa)])
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    in_band = np.empty(6 * m)
    in_band[order] = scale[: 6 * m]
    band = columns.T  # LAPACK's lower band: row d holds the d-th subdiagonal
    band *= in_band
    for d in range(band.shape[0]):
        band[d, : 6 * m - d] *= in_band[d:]
        band[d, 6 * m - d :] = 0.0
    border *= in_band[:, None] * scale[6 * m :]
    corner *= scale[6 * m :] * scale[6 * m :, None]
    lower, info = scipy.linalg.lapack.dpbtrf(band, lower=1)
    if info != 0:
        raise SingularBandError
    solved = scipy.linalg.cho_solve_banded((lower, True), border, check_finite=False) if a else border
    left, info = scipy.linalg.lapack.dpotrf(corner - border.T @ solved, lower=1, clean=1) if a else (corner, 0)
    if info != 0:
        raise SingularBandError
    factor = BandFactor(scale, lower, solved, border, left, order, root, white, white_a, g.image, g.point, np.nan)
    per_row = scale[:, None]
    inverse = inverse_norm(lambda b: factor.solve_orientation(b / per_row) / per_row, len(scale))
    # the 1-norm of a symmetric matrix is at most twice that of its lower triangle
    norm = 2.0 * float(np.abs(band).sum(axis=0).max() + np.abs(border).sum(axis=1).max(initial=0.0))
    factor = replace(factor, condition=1.0 / (norm * inverse))
    if not factor.condition >= condition_least:
        raise SingularBandError
    return factor
