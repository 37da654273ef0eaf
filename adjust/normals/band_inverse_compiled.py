"""The part of the inverse of a banded matrix that lies inside the band (Takahashi, Fagan & Chin 1973).

With B = L L^T, Z = B^-1, a block column J of L and the rows R below it inside the band, X = L_RJ L_JJ^-1:
Z_RJ = -Z_RR X and Z_JJ = (L_JJ L_JJ^T)^-1 + X^T Z_RR X, from the last columns to the first. Only a window of Z as wide
as the band is ever held as a dense matrix.

Readable form: `adjust.normals.cofactors.Cofactors`. Agreement: `tests/agreement/test_compiled_twins.py`.
"""

from __future__ import annotations

import numba
import numpy as np
import scipy.linalg

from adjust.normals.band import BandFactor
from simfield.block import Floats
from simfield.numerics import machine_code

machine_code.install()

COLUMNS = 48
"""columns a step: enough for dense products, few against the band"""


def band_of_inverse(band: Floats) -> Floats:
    """(size, w): element [c, r - c] is Z[r, c], from the Cholesky factor `band` (w, size) in LAPACK's lower form."""
    width, size = band.shape
    inverse = np.zeros((size, width))
    window = np.zeros((0, 0))
    first = size
    while first > 0:
        before, first = first, max(0, first - COLUMNS)
        count, below = before - first, min(width - 1, size - before)
        diagonal, left = _block_column(band, first, count, below)
        window = window[:below, :below]
        diagonal_inverse = scipy.linalg.lapack.dtrtri(diagonal, lower=1)[0]
        x = left @ diagonal_inverse
        z_left = -window @ x
        grown = np.empty((count + below, count + below))
        grown[count:, count:] = window
        grown[count:, :count] = z_left
        grown[:count, count:] = z_left.T
        grown[:count, :count] = diagonal_inverse.T @ diagonal_inverse - x.T @ z_left
        window = grown
        for c in range(count):
            rows = min(width, size - first - c, count + below - c)
            inverse[first + c, :rows] = window[c : c + rows, c]
    return inverse


def _block_column(band: Floats, first: int, count: int, below: int) -> tuple[Floats, Floats]:
    """L_JJ (count, count) and L_RJ (below, count) of the columns first .. first + count - 1, as dense matrices."""
    width = band.shape[0]
    dense = np.zeros((count + below, count))
    for c in range(count):
        rows = min(width, count + below - c)
        dense[c : c + rows, c] = band[:rows, first + c]
    return dense[:count], dense[count:]


@numba.njit(cache=True, error_model="numpy")
def _spread_over_points(ray_starts, rays, place, image, white, inverse, out):  # type: ignore[no-untyped-def]
    """out (n, 3, 3) += sum over pairs of rays of white_a Z[image a, image b] white_b^T."""
    product = np.empty((3, 6))
    for p in range(ray_starts.size - 1):
        for ka in range(ray_starts[p], ray_starts[p + 1]):
            a = rays[ka]
            ia = place[image[a]]
            for kb in range(ray_starts[p], ray_starts[p + 1]):
                b = rays[kb]
                ib = place[image[b]]
                for j in range(3):
                    for c in range(6):
                        column, total = 6 * ib + c, 0.0
                        for r in range(6):
                            row = 6 * ia + r
                            z = inverse[column, row - column] if row >= column else inverse[row, column - row]
                            total += white[a, j, r] * z
                        product[j, c] = total
                for j in range(3):
                    for q in range(3):
                        for c in range(6):
                            out[p, j, q] += product[j, c] * white[b, q, c]


def band_cofactors(factor: BandFactor) -> tuple[Floats, Floats]:
    """The diagonal of Q_ee (E) and the blocks (n, 3, 3) of Q_pp, without forming a full inverse."""
    size, n = len(factor.order), len(factor.root)
    inverse = band_of_inverse(factor.band)
    corner = np.empty((0, 0))
    if len(factor.corner):
        corner = scipy.linalg.cho_solve((factor.corner, True), np.eye(len(factor.corner)))
    scale = factor.scale[:size]
    diagonal = inverse[:, 0] + np.einsum("ia,ab,ib->i", factor.solved, corner, factor.solved)
    diagonal = np.concatenate([diagonal[factor.order] * scale**2, np.diag(corner) * factor.scale[size:] ** 2])
    scaled_white = factor.white * scale.reshape(-1, 6)[factor.image][:, None, :]
    place = factor.order[::6] // 6
    rays = np.argsort(factor.point, kind="stable")
    ray_starts = np.searchsorted(factor.point[rays], np.arange(n + 1))
    spread = np.zeros((n, 3, 3))
    _spread_over_points(ray_starts, rays, place, factor.image, scaled_white, inverse, spread)
    solved = factor.solved.reshape(len(place), 6, -1)[place]
    border = -factor.white_a * factor.scale[size:]
    np.add.at(border, factor.point, scaled_white @ solved[factor.image])
    spread += border @ corner @ border.transpose(0, 2, 1)
    root = factor.root
    return diagonal, np.asarray(root.transpose(0, 2, 1) @ (np.eye(3) + spread) @ root)
