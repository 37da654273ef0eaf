"""The film of many trials in compiled loops: coefficients drawn by counter, and measured = ideal + d(measured) solved.

Trials are the last, contiguous axis; T of them, a multiple of PERIOD. The arithmetic of a trial does not depend on its
neighbours, but its last bit may depend on T, as loops are compiled in pieces of some width; so T is always the same.
The readable forms are `simfield.distortion.draw_film` and `measured_from_ideal`.
"""

from __future__ import annotations

import numba
import numpy as np

from simfield.compiled_draws import PERIOD, _box_muller, _philox

COLUMNS = 9
CORRECTIONS = 2
"""of what is not linear: a film that moves by 0.3 mm, with a curvature of 4e-5 / mm, is solved to 1e-13 mm after two"""
ZERO = np.uint64(0)


@numba.njit(cache=True, error_model="numpy")
def draw_pairs(first, second, start, k0, k1, drawn, out):  # type: ignore[no-untyped-def]
    """out (2, T) the pairs of the trials from `start` on, a multiple of PERIOD; drawn (4, T / 2) is scratch."""
    counters = out.shape[1] // 2
    low = np.uint64(start) >> np.uint64(1)
    for c in range(counters):
        w0, w1, w2, w3 = _philox(first, second, low + np.uint64(c), ZERO, k0, k1)
        drawn[0, c], drawn[1, c] = _box_muller(w0, w1)
        drawn[2, c], drawn[3, c] = _box_muller(w2, w3)
    for group in range(counters // 8):
        for c in range(8):
            here, there = 8 * group + c, 16 * group + c
            out[0, there], out[1, there] = drawn[0, here], drawn[1, here]
            out[0, there + 8], out[1, there + 8] = drawn[2, here], drawn[3, here]


@numba.njit(cache=True, error_model="numpy")
def film_coefficients(begin, end, column, sigma, key, owner, start, drawn, pair, out):  # type: ignore[no-untyped-def]
    """out (2, COLUMNS, T): the coefficients of an image, from the rows begin .. end - 1 of a FilmTable."""
    out[:] = 0.0
    for row in range(begin, end):
        c = column[row]
        draw_pairs(np.uint64(c), owner[row], start, key[row, 0], key[row, 1], drawn, pair)
        for axis in range(2):
            s = sigma[row, axis]
            for t in range(out.shape[2]):
                out[axis, c, t] += s * pair[axis, t]


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def solve_film(x, y, local, row, c, shift, u):  # type: ignore[no-untyped-def]
    """u (2, T) solves u = shift (2, T) + local(u) + film((x, y) + u).

    (x, y): the place on the film, with the deformation that all trials share; local (k, 2, 5): that deformation around
    the places (simfield.expansion), of which `row` is this one; c (2, COLUMNS, T). The part of the right side that is
    linear in u goes to the left and is solved for; CORRECTIONS evaluations of the rest follow.
    """
    xx, xy, yy = x * x, x * y, y * y
    xxx, xxy, xyy, yyy = x * xx, x * xy, x * yy, y * yy
    a0, a1, a2, a3, a4 = local[row, 0, 0], local[row, 0, 1], local[row, 0, 2], local[row, 0, 3], local[row, 0, 4]
    b0, b1, b2, b3, b4 = local[row, 1, 0], local[row, 1, 1], local[row, 1, 2], local[row, 1, 3], local[row, 1, 4]
    for t in range(u.shape[1]):
        p0, p1, p2, p3, p4 = c[0, 0, t], c[0, 1, t], c[0, 2, t], c[0, 3, t], c[0, 4, t]
        p5, p6, p7, p8 = c[0, 5, t], c[0, 6, t], c[0, 7, t], c[0, 8, t]
        q0, q1, q2, q3, q4 = c[1, 0, t], c[1, 1, t], c[1, 2, t], c[1, 3, t], c[1, 4, t]
        q5, q6, q7, q8 = c[1, 5, t], c[1, 6, t], c[1, 7, t], c[1, 8, t]
        f = shift[0, t] + p0 * x + p1 * y + p2 * xx + p3 * xy + p4 * yy + p5 * xxx + p6 * xxy + p7 * xyy + p8 * yyy
        g = shift[1, t] + q0 * x + q1 * y + q2 * xx + q3 * xy + q4 * yy + q5 * xxx + q6 * xxy + q7 * xyy + q8 * yyy
        # derivatives at (x, y): first, and half the second but for the mixed one
        fx = a0 + p0 + 2.0 * p2 * x + p3 * y + 3.0 * p5 * xx + 2.0 * p6 * xy + p7 * yy
        fy = a1 + p1 + p3 * x + 2.0 * p4 * y + p6 * xx + 2.0 * p7 * xy + 3.0 * p8 * yy
        gx = b0 + q0 + 2.0 * q2 * x + q3 * y + 3.0 * q5 * xx + 2.0 * q6 * xy + q7 * yy
        gy = b1 + q1 + q3 * x + 2.0 * q4 * y + q6 * xx + 2.0 * q7 * xy + 3.0 * q8 * yy
        fxx, fxy, fyy = (
            a2 + p2 + 3.0 * p5 * x + p6 * y,
            a3 + p3 + 2.0 * (p6 * x + p7 * y),
            a4 + p4 + p7 * x + 3.0 * p8 * y,
        )
        gxx, gxy, gyy = (
            b2 + q2 + 3.0 * q5 * x + q6 * y,
            b3 + q3 + 2.0 * (q6 * x + q7 * y),
            b4 + q4 + q7 * x + 3.0 * q8 * y,
        )
        by_determinant = 1.0 / ((1.0 - fx) * (1.0 - gy) - fy * gx)
        r, s = f, g
        v, w = 0.0, 0.0
        for correction in range(CORRECTIONS + 1):
            v = ((1.0 - gy) * r + fy * s) * by_determinant
            w = (gx * r + (1.0 - fx) * s) * by_determinant
            if correction < CORRECTIONS:
                vv, vw, ww = v * v, v * w, w * w
                r = f + (fxx + p5 * v + p6 * w) * vv + fxy * vw + (fyy + p7 * v + p8 * w) * ww
                s = g + (gxx + q5 * v + q6 * w) * vv + gxy * vw + (gyy + q7 * v + q8 * w) * ww
        u[0, t], u[1, t] = v, w


@numba.njit(cache=True, error_model="numpy")
def add_film(lanes, start, rows, ends, place, local, table_ends, column, sigma, key, owner):  # type: ignore[no-untyped-def]
    """Add place (k, 2) and the film's displacement of the trials from `start` on to lanes (tiles, k, 2, 8).

    Two tiles are computed at a time.

    rows: the observations sorted by image, those of image i from ends[i] to ends[i + 1]; table_ends likewise for the
    FilmTable (column, sigma, key, owner); local (k, 2, 5).
    """
    drawn, pair, u = np.empty((4, 8)), np.empty((2, PERIOD)), np.empty((2, PERIOD))
    c, still = np.empty((2, COLUMNS, PERIOD)), np.zeros((2, PERIOD))
    for two in range(0, lanes.shape[0], 2):
        own = start + 8 * two
        for i in range(len(ends) - 1):
            if ends[i] == ends[i + 1]:
                continue
            film_coefficients(table_ends[i], table_ends[i + 1], column, sigma, key, owner, own, drawn, pair, c)
            for at in range(ends[i], ends[i + 1]):
                row = rows[at]
                x, y = place[row, 0], place[row, 1]
                solve_film(x, y, local, row, c, still, u)
                for t in range(PERIOD):
                    lanes[two + t // 8, row, 0, t % 8] += x + u[0, t]
                    lanes[two + t // 8, row, 1, t % 8] += y + u[1, t]
