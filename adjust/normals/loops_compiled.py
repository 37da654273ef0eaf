"""Compiled loops for the normal equations of one adjustment; adjust.normals.normals_compiled calls them.

All arrays are those of adjust.observations.image_points.ImagePoints, sorted by image. m images, k observations, n
points.

Readable form: `adjust.normals.normals.Plain`. Agreement: `tests/adjust/normals/test_schur.py`.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

from simfield.numerics import compile_notice, machine_code

compile_notice.install()
machine_code.install()


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def linearise(
    exterior: Any, rotation: Any, renamed: Any, interior: Any, points: Any, starts: Any, point: Any, xy: Any, v: Any,
    by_exterior: Any, by_point: Any,
) -> float:  # fmt: skip
    """Corrections and derivatives without additional parameters; returns the least depth.

    exterior (m, 6), rotation (m, 3, 3), renamed (m) bool, interior (m, 3), points (n, 3), starts (m + 1), point (k),
    xy (k, 2). On entry v (k, 2) holds d(measured); on return projected + d(measured) - measured. by_exterior (k, 2,
    6), by_point (k, 2, 3). A small turn about the object axis a changes the projection by -by_point (a x ray); the
    angles turn about e1, R1 e2 and R e3, of the renamed axes where they are.
    """
    least = np.inf
    for i in range(starts.size - 1):
        r = rotation[i]
        co, so = np.cos(exterior[i, 3]), np.sin(exterior[i, 3])
        ax, ay, az = r[0, 2], r[1, 2], r[2, 2]
        c = interior[i, 0]
        for k in range(starts[i], starts[i + 1]):
            p = point[k]
            x, y, z = points[p, 0] - exterior[i, 0], points[p, 1] - exterior[i, 1], points[p, 2] - exterior[i, 2]
            p1 = r[0, 0] * x + r[1, 0] * y + r[2, 0] * z
            p2 = r[0, 1] * x + r[1, 1] * y + r[2, 1] * z
            p3 = r[0, 2] * x + r[1, 2] * y + r[2, 2] * z
            least = min(least, -p3)
            if not -p3 > 0.0:
                least = min(least, 0.0)
            f = -c / p3
            u, w = p1 / p3, p2 / p3
            v[k, 0] += interior[i, 1] - c * u - xy[k, 0]
            v[k, 1] += interior[i, 2] - c * w - xy[k, 1]
            for j in range(3):
                by_point[k, 0, j] = f * (r[j, 0] - u * r[j, 2])
                by_point[k, 1, j] = f * (r[j, 1] - w * r[j, 2])
            for q in range(2):
                gx, gy, gz = by_point[k, q, 0], by_point[k, q, 1], by_point[k, q, 2]
                by_exterior[k, q, 0], by_exterior[k, q, 1], by_exterior[k, q, 2] = -gx, -gy, -gz
                tx, ty, tz = y * gz - z * gy, z * gx - x * gz, x * gy - y * gx
                by_exterior[k, q, 5] = -(ax * tx + ay * ty + az * tz)
                if renamed[i]:
                    tx, ty, tz = ty, tz, tx
                by_exterior[k, q, 3] = -tx
                by_exterior[k, q, 4] = -(co * ty + so * tz)
    return least


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def accumulate(
    starts: Any, point: Any, weight: Any, free: Any, first: Any, v: Any, by_exterior: Any, by_point: Any, basis: Any,
    ee: Any, ea: Any, pe: Any, pa: Any, pp: Any, gradient_e: Any, gradient_a: Any, gradient_p: Any,
) -> float:  # fmt: skip
    """Sums over the image points; returns their vPv.

    weight (k, 2), free (n, 3) 1 or 0, first (m) first column of the image's AP set, basis (k, 2, a).
    Added to: ee (m, 6, 6), ea (m, 6, A), pa (n, 3, A), pp (n, 3, 3), gradient_e (m, 6), gradient_a (A),
    gradient_p (n, 3). Written: pe (k, 3, 6). by_point gets zero columns for coordinates held fixed.
    """
    vpv = 0.0
    width = basis.shape[2]
    for i in range(starts.size - 1):
        a0 = first[i]
        for k in range(starts[i], starts[i + 1]):
            p = point[k]
            pe[k] = 0.0
            for q in range(2):
                w, vq = weight[k, q], v[k, q]
                vpv += w * vq * vq
                for j in range(3):
                    by_point[k, q, j] *= free[p, j]
                for j in range(6):
                    wj = w * by_exterior[k, q, j]
                    gradient_e[i, j] += wj * vq
                    for r in range(j + 1):
                        ee[i, j, r] += wj * by_exterior[k, q, r]
                    for r in range(width):
                        ea[i, j, a0 + r] += wj * basis[k, q, r]
                for j in range(3):
                    wj = w * by_point[k, q, j]
                    gradient_p[p, j] += wj * vq
                    for r in range(3):
                        pp[p, j, r] += wj * by_point[k, q, r]
                    for r in range(6):
                        pe[k, j, r] += wj * by_exterior[k, q, r]
                    for r in range(width):
                        pa[p, j, a0 + r] += wj * basis[k, q, r]
                for r in range(width):
                    gradient_a[a0 + r] += w * vq * basis[k, q, r]
    return vpv


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def gradient(
    starts: Any, point: Any, weight: Any, free: Any, first: Any, v: Any, by_exterior: Any, by_point: Any, basis: Any,
    gradient_e: Any, gradient_a: Any, gradient_p: Any,
) -> float:  # fmt: skip
    """The gradients of `accumulate` alone; returns vPv."""
    vpv = 0.0
    for i in range(starts.size - 1):
        a0 = first[i]
        for k in range(starts[i], starts[i + 1]):
            p = point[k]
            for q in range(2):
                f = weight[k, q] * v[k, q]
                vpv += f * v[k, q]
                for j in range(6):
                    gradient_e[i, j] += f * by_exterior[k, q, j]
                for j in range(3):
                    gradient_p[p, j] += f * by_point[k, q, j] * free[p, j]
                for r in range(basis.shape[2]):
                    gradient_a[a0 + r] += f * basis[k, q, r]
    return vpv


@numba.njit(cache=True, error_model="numpy")
def add_rays(point: Any, station: Any, direction: Any, matrix: Any, right: Any) -> None:
    """The normal equations matrix (n, 3, 3), right (n, 3) of the points nearest to all their rays.

    Of each ray (k): its point, a station (k, 3) on it and its unit direction (k, 3).
    """
    for k in range(point.size):
        p = point[k]
        for i in range(3):
            for j in range(3):
                across = (1.0 if i == j else 0.0) - direction[k, i] * direction[k, j]
                matrix[p, i, j] += across
                right[p, i] += across * station[k, j]


@numba.njit(cache=True, error_model="numpy")
def cholesky_blocks(pp: Any, least: float, lower: Any) -> int:
    """The inverse lower Cholesky factor L^-1 of every pp (n, 3, 3) into lower.

    Returns -1, or the first point whose unit-diagonal determinant is not above `least`.
    """
    for p in range(pp.shape[0]):
        a, d, f = pp[p, 0, 0], pp[p, 1, 1], pp[p, 2, 2]
        b, c, e = pp[p, 1, 0], pp[p, 2, 0], pp[p, 2, 1]
        determinant = a * (d * f - e * e) - b * (b * f - e * c) + c * (b * e - d * c)
        if not determinant > least * a * d * f:
            return p
        l00 = np.sqrt(a)
        l10, l20 = b / l00, c / l00
        l11 = np.sqrt(d - l10 * l10)
        l21 = (e - l20 * l10) / l11
        l22 = np.sqrt(f - l20 * l20 - l21 * l21)
        lower[p, 0, 0], lower[p, 1, 1], lower[p, 2, 2] = 1.0 / l00, 1.0 / l11, 1.0 / l22
        lower[p, 1, 0] = -l10 / (l00 * l11)
        lower[p, 2, 1] = -l21 / (l11 * l22)
        lower[p, 2, 0] = (l10 * l21 - l20 * l11) / (l00 * l11 * l22)
        lower[p, 0, 1] = lower[p, 0, 2] = lower[p, 1, 2] = 0.0
    return -1


@numba.njit(cache=True, error_model="numpy")
def whiten(point: Any, lower: Any, pe: Any, out: Any) -> None:
    """out (k, 3, 6) = L^-1 of the point times pe (k, 3, 6)."""
    for k in range(point.size):
        inverse = lower[point[k]]
        for r in range(6):
            x, y, z = pe[k, 0, r], pe[k, 1, r], pe[k, 2, r]
            out[k, 0, r] = inverse[0, 0] * x
            out[k, 1, r] = inverse[1, 0] * x + inverse[1, 1] * y
            out[k, 2, r] = inverse[2, 0] * x + inverse[2, 1] * y + inverse[2, 2] * z


@numba.njit(cache=True, error_model="numpy")
def scatter(starts: Any, point: Any, white: Any, dense: Any) -> None:
    """white (k, 3, 6) into dense (3n, 6m + A): the rows of their points, the columns of their images."""
    for i in range(starts.size - 1):
        for k in range(starts[i], starts[i + 1]):
            for j in range(3):
                for r in range(6):
                    dense[3 * point[k] + j, 6 * i + r] = white[k, j, r]


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def reduce_band(
    ray_starts: Any, rays: Any, image: Any, place: Any, white: Any, white_a: Any, band: Any, border: Any
) -> None:
    """Subtract what the eliminated points contribute: band and border of the reduced matrix.

    ray_starts (n + 1), rays (k): the observations of every point; image (k); place (m): the position of each image
    in the band's order; white (k, 3, 6), white_a (n, 3, A). band (6m, w): band[c, r - c] holds row r >= c of column c;
    border (6m, A) in the band's order.
    """
    for p in range(ray_starts.size - 1):
        for ka in range(ray_starts[p], ray_starts[p + 1]):
            a = rays[ka]
            ia = place[image[a]]
            for j in range(6):
                w0, w1, w2 = white[a, 0, j], white[a, 1, j], white[a, 2, j]
                for r in range(border.shape[1]):
                    border[6 * ia + j, r] -= w0 * white_a[p, 0, r] + w1 * white_a[p, 1, r] + w2 * white_a[p, 2, r]
            for kb in range(ray_starts[p], ray_starts[p + 1]):
                b = rays[kb]
                ib = place[image[b]]
                if ib < ia:
                    continue
                for j in range(6):
                    column = 6 * ia + j
                    w0, w1, w2 = white[a, 0, j], white[a, 1, j], white[a, 2, j]
                    for r in range(j if ib == ia else 0, 6):
                        row = 6 * ib + r
                        band[column, row - column] -= w0 * white[b, 0, r] + w1 * white[b, 1, r] + w2 * white[b, 2, r]
