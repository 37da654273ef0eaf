"""The film of many trials in compiled loops: coefficients drawn by counter, and measured = ideal + d(measured) solved.

Written in lanes (simfield.numerics.lanes): a tile of WIDTH trials at a time, whose arithmetic does not depend on its
neighbours. The readable forms are `simfield.disturbances.film.draw_film` and `measured_from_ideal`.

Readable form: `simfield.disturbances.film.draw_film`. Agreement: `tests/simfield/disturbances/test_draws.py`.
"""

from __future__ import annotations

import numba
import numpy as np

from simfield.numerics import WIDTH, align_stack, inlined, kernel, load, same, store
from simfield.random import draw, drawn_of

COLUMNS = 9
CORRECTIONS = 2
"""of what is not linear: a film that moves by 0.3 mm, with a curvature of 4e-5 / mm, is solved to 1e-13 mm after two"""


@kernel
def film_coefficients(begin, end, column, sigma, key, owner, start, drawn, film):  # type: ignore[no-untyped-def]
    """film (tiles, 2, COLUMNS, WIDTH): the coefficients of an image, from the rows begin .. end - 1 of a FilmTable.

    drawn: room for pairs, as in `simfield.random.counter_normals_compiled.draw`.
    """
    film[:] = 0.0
    for row in range(begin, end):
        c = column[row]
        draw(np.uint64(c), owner[row], start, key[row, 0], key[row, 1], drawn)
        for tile in range(film.shape[0]):
            for axis in range(2):
                store(film, load(film, tile, axis, c) + sigma[row, axis] * drawn_of(drawn, tile, axis), tile, axis, c)


@inlined
def solve_film(x, y, local, row, film, tile, shift_x, shift_y):  # type: ignore[no-untyped-def]
    """(u, v), lanes that solve (u, v) = shift + local(u, v) + film((x, y) + (u, v)).

    (x, y): the place on the film, with the deformation that all trials share; local (k, 2, 5): that deformation around
    the places (simfield.disturbances.expansion), of which `row` is this one; film (tiles, 2, COLUMNS, WIDTH). The
    part of the right side that is linear in (u, v) goes to the left and is solved for; CORRECTIONS evaluations of the
    rest follow.
    """
    xx, xy, yy = x * x, x * y, y * y
    p0, p1, p2 = load(film, tile, 0, 0), load(film, tile, 0, 1), load(film, tile, 0, 2)
    p3, p4, p5 = load(film, tile, 0, 3), load(film, tile, 0, 4), load(film, tile, 0, 5)
    p6, p7, p8 = load(film, tile, 0, 6), load(film, tile, 0, 7), load(film, tile, 0, 8)
    q0, q1, q2 = load(film, tile, 1, 0), load(film, tile, 1, 1), load(film, tile, 1, 2)
    q3, q4, q5 = load(film, tile, 1, 3), load(film, tile, 1, 4), load(film, tile, 1, 5)
    q6, q7, q8 = load(film, tile, 1, 6), load(film, tile, 1, 7), load(film, tile, 1, 8)
    f = shift_x + (p0 * x + p1 * y + p2 * xx) + (p3 * xy + p4 * yy) + (p5 * x + p6 * y) * xx + (p7 * x + p8 * y) * yy
    g = shift_y + (q0 * x + q1 * y + q2 * xx) + (q3 * xy + q4 * yy) + (q5 * x + q6 * y) * xx + (q7 * x + q8 * y) * yy
    # derivatives at (x, y): first, and half the second but for the mixed one
    fx = local[row, 0, 0] + p0 + 2.0 * x * p2 + y * p3 + 3.0 * xx * p5 + 2.0 * xy * p6 + yy * p7
    fy = local[row, 0, 1] + p1 + x * p3 + 2.0 * y * p4 + xx * p6 + 2.0 * xy * p7 + 3.0 * yy * p8
    gx = local[row, 1, 0] + q0 + 2.0 * x * q2 + y * q3 + 3.0 * xx * q5 + 2.0 * xy * q6 + yy * q7
    gy = local[row, 1, 1] + q1 + x * q3 + 2.0 * y * q4 + xx * q6 + 2.0 * xy * q7 + 3.0 * yy * q8
    fxx, gxx = local[row, 0, 2] + p2 + 3.0 * x * p5 + y * p6, local[row, 1, 2] + q2 + 3.0 * x * q5 + y * q6
    fxy, gxy = (
        local[row, 0, 3] + p3 + 2.0 * x * p6 + 2.0 * y * p7,
        local[row, 1, 3] + q3 + 2.0 * x * q6 + 2.0 * y * q7,
    )
    fyy, gyy = local[row, 0, 4] + p4 + x * p7 + 3.0 * y * p8, local[row, 1, 4] + q4 + x * q7 + 3.0 * y * q8
    by_determinant = 1.0 / ((1.0 - fx) * (1.0 - gy) - fy * gx)
    h11, h12 = (1.0 - gy) * by_determinant, fy * by_determinant
    h21, h22 = gx * by_determinant, (1.0 - fx) * by_determinant
    u, v = h11 * f + h12 * g, h21 * f + h22 * g
    for _ in range(CORRECTIONS):
        uu, uv, vv = u * u, u * v, v * v
        r = f + (fxx + p5 * u + p6 * v) * uu + fxy * uv + (fyy + p7 * u + p8 * v) * vv
        s = g + (gxx + q5 * u + q6 * v) * uu + gxy * uv + (gyy + q7 * u + q8 * v) * vv
        u, v = h11 * r + h12 * s, h21 * r + h22 * s
    return u, v


@numba.njit(cache=True, error_model="numpy")
def add_film(lanes, start, rows, ends, place, local, table_ends, column, sigma, key, owner):  # type: ignore[no-untyped-def]
    """Add place (k, 2) and the film's displacement of the trials from `start` on to lanes (tiles, k, 2, WIDTH).

    rows: the observations sorted by image, those of image i from ends[i] to ends[i + 1]; table_ends likewise for the
    FilmTable (column, sigma, key, owner); local (k, 2, 5).
    """
    align_stack()
    drawn, film, still = np.empty(4 * WIDTH), np.empty((2, 2, COLUMNS, WIDTH)), same(0.0)
    for two in range(0, lanes.shape[0], 2):
        for i in range(len(ends) - 1):
            if ends[i] == ends[i + 1]:
                continue
            film_coefficients(
                table_ends[i], table_ends[i + 1], column, sigma, key, owner, start + WIDTH * two, drawn, film
            )
            for at in range(ends[i], ends[i + 1]):
                row = rows[at]
                x, y = place[row, 0], place[row, 1]
                for half in range(2):
                    u, v = solve_film(x, y, local, row, film, half, still, still)
                    store(lanes, load(lanes, two + half, row, 0) + (x + u), two + half, row, 0)
                    store(lanes, load(lanes, two + half, row, 1) + (y + v), two + half, row, 1)
