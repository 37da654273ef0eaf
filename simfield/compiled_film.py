"""The film of many trials in compiled loops: coefficients drawn by counter, and measured = ideal + d(measured) solved.

Trials are the last, contiguous axis; T of them, a multiple of PERIOD. The arithmetic of a trial does not depend on its
neighbours. The readable forms are `simfield.distortion.draw_film` and `measured_from_ideal`.
"""

from __future__ import annotations

import numba
import numpy as np

from simfield.compiled_draws import _box_muller, _philox

COLUMNS = 9
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


@numba.njit(cache=True, error_model="numpy")
def solve_film(x0, y0, local, row, c, steps, shift, u):  # type: ignore[no-untyped-def]
    """u (2, T) solves u = shift (2, T) + local(u) + film(x0 + u) in a fixed number of steps.

    (x0, y0): the place on the film, with the deformation that all trials share; local (k, 2, 5): that deformation
    around the places (simfield.expansion), of which `row` is this one; c (2, COLUMNS, T).
    """
    lanes = u.shape[1]
    for t in range(lanes):
        u[0, t], u[1, t] = shift[0, t], shift[1, t]
    a0, a1, a2, a3, a4 = local[row, 0, 0], local[row, 0, 1], local[row, 0, 2], local[row, 0, 3], local[row, 0, 4]
    b0, b1, b2, b3, b4 = local[row, 1, 0], local[row, 1, 1], local[row, 1, 2], local[row, 1, 3], local[row, 1, 4]
    for _ in range(steps):
        for t in range(lanes):
            p, q = u[0, t], u[1, t]
            x, y = x0 + p, y0 + q
            xx, xy, yy = x * x, x * y, y * y
            dx = x * (c[0, 0, t] + c[0, 2, t] * x + c[0, 3, t] * y + c[0, 5, t] * xx + c[0, 6, t] * xy + c[0, 7, t] * yy)
            dx += y * (c[0, 1, t] + c[0, 4, t] * y + c[0, 8, t] * yy)
            dy = x * (c[1, 0, t] + c[1, 2, t] * x + c[1, 3, t] * y + c[1, 5, t] * xx + c[1, 6, t] * xy + c[1, 7, t] * yy)
            dy += y * (c[1, 1, t] + c[1, 4, t] * y + c[1, 8, t] * yy)
            pp, pq, qq = p * p, p * q, q * q
            u[0, t] = shift[0, t] + dx + (a0 * p + a1 * q + a2 * pp + a3 * pq + a4 * qq)
            u[1, t] = shift[1, t] + dy + (b0 * p + b1 * q + b2 * pp + b3 * pq + b4 * qq)


@numba.njit(cache=True, error_model="numpy")
def add_film(lanes, start, rows, ends, place, local, table_ends, column, sigma, key, owner, steps):  # type: ignore[no-untyped-def]
    """Add place (k, 2) and the film's displacement of the trials from `start` on to lanes (tiles, k, 2, 8).

    rows: the observations sorted by image, those of image i from ends[i] to ends[i + 1]; table_ends likewise for the
    FilmTable (column, sigma, key, owner); local (k, 2, 5); steps as in solve_film.
    """
    count = 8 * lanes.shape[0]
    drawn, pair, u = np.empty((4, count // 2)), np.empty((2, count)), np.empty((2, count))
    c, still = np.empty((2, COLUMNS, count)), np.zeros((2, count))
    for i in range(len(ends) - 1):
        if ends[i] == ends[i + 1]:
            continue
        film_coefficients(table_ends[i], table_ends[i + 1], column, sigma, key, owner, start, drawn, pair, c)
        for at in range(ends[i], ends[i + 1]):
            row = rows[at]
            x, y = place[row, 0], place[row, 1]
            solve_film(x, y, local, row, c, steps, still, u)
            for tile in range(lanes.shape[0]):
                for t in range(8):
                    lanes[tile, row, 0, t] += x + u[0, 8 * tile + t]
                    lanes[tile, row, 1, t] += y + u[1, 8 * tile + t]
