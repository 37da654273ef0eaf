"""Least squares of a few unknowns in lanes: a normal equation for every trial of a tile, and the reseau correction.

Readable form of the latter: `adjust.reductions.reseau`.
"""

from __future__ import annotations

import numba
import numpy as np

import simfield.lanes_compiled  # noqa: F401  lanes for numba
from adjust.reductions.inner import UNIT_MM
from simfield.lanes import align_stack, load, root, same, store

MOST_DEGREE = 5
"""of a reseau correction; normal equations of higher polynomials lose too many digits"""
MOST_TERMS = (MOST_DEGREE + 1) * (MOST_DEGREE + 2) // 2
MOST_MOMENTS = (2 * MOST_DEGREE + 1) * (2 * MOST_DEGREE + 2) // 2
DEGREE = np.array([d for d in range(MOST_DEGREE + 1) for _ in range(d + 1)])
"""of the monomials x^(d - j) y^j, which stand in this order: 1, x, y, x^2, xy, y^2 ..."""


@numba.njit(cache=True, error_model="numpy", _nrt=False)
def add_row(columns, row, right, normal, gradient):  # type: ignore[no-untyped-def]
    """normal (p, p, WIDTH) += row row^T, the lower triangle alone; gradient (p, w, WIDTH) += row right^T (w, WIDTH).

    columns: those of row (p, WIDTH) that are not 0, in rising order.
    """
    for a in range(len(columns)):
        i = columns[a]
        own = load(row, i)
        for b in range(a + 1):
            j = columns[b]
            store(normal, load(normal, i, j) + own * load(row, j), i, j)
        for w in range(right.shape[0]):
            store(gradient, load(gradient, i, w) + own * load(right, w), i, w)


@numba.njit(cache=True, error_model="numpy", _nrt=False)
def solve_normal(p, normal, right):  # type: ignore[no-untyped-def]
    """right (p, w, WIDTH) becomes normal^-1 right in every trial, by Cholesky; of normal (p, p, WIDTH) the lower
    triangle. Arrays may have more rows than p.
    """
    align_stack()
    for i in range(p):
        for j in range(i):
            rest = load(normal, i, j)
            for k in range(j):
                rest = rest - load(normal, i, k) * load(normal, j, k)
            store(normal, rest * load(normal, j, j), i, j)
        rest = load(normal, i, i)
        for k in range(i):
            rest = rest - load(normal, i, k) * load(normal, i, k)
        # the diagonal holds the reciprocal of the root
        store(normal, 1.0 / root(rest), i, i)
    for w in range(right.shape[1]):
        for i in range(p):
            rest = load(right, i, w)
            for k in range(i):
                rest = rest - load(normal, i, k) * load(right, k, w)
            store(right, rest * load(normal, i, i), i, w)
        for i in range(p - 1, -1, -1):
            rest = load(right, i, w)
            for k in range(i + 1, p):
                rest = rest - load(normal, k, i) * load(right, k, w)
            store(right, rest * load(normal, i, i), i, w)


@numba.njit(cache=True, error_model="numpy", _nrt=False)
def monomials(degree, x, y, row):  # type: ignore[no-untyped-def]
    """row (terms, WIDTH): 1, x, y, x^2, xy, y^2 ... of lanes x and y in mm, in units of UNIT_MM."""
    x, y = x * (1.0 / UNIT_MM), y * (1.0 / UNIT_MM)
    store(row, same(1.0), 0)
    for d in range(1, degree + 1):
        begin, before = d * (d + 1) // 2, (d - 1) * d // 2
        for j in range(d):
            store(row, load(row, before + j) * x, begin + j)
        store(row, load(row, before + d - 1) * y, begin + d)


@numba.njit(cache=True, error_model="numpy", _nrt=False)
def fit_reseau(degree, cross, places, marks, work, shift):  # type: ignore[no-untyped-def]
    """shift (MOST_TERMS, 2, WIDTH): coefficients of the correction that brings the crosses to their places.

    cross (r): which of marks (s, 2, WIDTH) mm are crosses; places (s, 2) mm; work: a `Work`. The normal equations are
    moments, sums of monomials of twice the degree, of which many products share one.
    """
    align_stack()
    terms, twice = (degree + 1) * (degree + 2) // 2, (2 * degree + 1) * (2 * degree + 2) // 2
    row, moment = work.row, work.moment
    moment[:], shift[:] = 0.0, 0.0
    for s in cross:
        x, y = load(marks, s, 0), load(marks, s, 1)
        monomials(2 * degree, x, y, row)
        for m in range(twice):
            store(moment, load(moment, m) + load(row, m), m)
        dx, dy = places[s, 0] - x, places[s, 1] - y
        for m in range(terms):
            own = load(row, m)
            store(shift, load(shift, m, 0) + own * dx, m, 0)
            store(shift, load(shift, m, 1) + own * dy, m, 1)
    for i in range(terms):
        for j in range(i + 1):
            d = DEGREE[i] + DEGREE[j]
            of_y = i - DEGREE[i] * (DEGREE[i] + 1) // 2 + j - DEGREE[j] * (DEGREE[j] + 1) // 2
            store(work.normal, load(moment, d * (d + 1) // 2 + of_y), i, j)
    solve_normal(terms, work.normal, shift)


@numba.njit(cache=True, error_model="numpy", _nrt=False)
def without_shift(degree, shift, tile, x, y, row):  # type: ignore[no-untyped-def]
    """Lanes (x, y) mm with the correction that `fit_reseau` has found."""
    monomials(degree, x, y, row)
    for m in range((degree + 1) * (degree + 2) // 2):
        own = load(row, m)
        x, y = x + own * load(shift, tile, m, 0), y + own * load(shift, tile, m, 1)
    return x, y
