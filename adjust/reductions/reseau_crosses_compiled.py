"""Least squares of a few unknowns in lanes: a normal equation for every trial of a tile, and the reseau correction.

Readable form: `adjust.reductions.reseau_crosses`. Agreement: `tests/agreement/test_measured_trials.py`.
"""

from __future__ import annotations

from adjust.reductions.inner import UNIT_MM
from simfield.numerics import align_stack, inlined, kernel, load, root, same, store

MOST_DEGREE = 5
"""of a reseau correction; normal equations of higher polynomials lose too many digits"""
MOST_TERMS = (MOST_DEGREE + 1) * (MOST_DEGREE + 2) // 2
MOST_POWERS = 2 * MOST_DEGREE + 1
"""powers of a coordinate, with that to 0, in sums of products of two monomials"""


@kernel
def add_row(terms, row, right, normal, gradient):  # type: ignore[no-untyped-def]
    """normal (p, p, WIDTH) += row row^T, the lower triangle alone; gradient (p, w, WIDTH) += row right^T (w, WIDTH).

    terms: how many numbers of row (p, WIDTH) there are.
    """
    for i in range(terms):
        own = load(row, i)
        for j in range(i + 1):
            store(normal, load(normal, i, j) + own * load(row, j), i, j)
        for w in range(right.shape[0]):
            store(gradient, load(gradient, i, w) + own * load(right, w), i, w)


@kernel
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


@kernel
def fit_reseau(degree, cross, places, marks, work, shift):  # type: ignore[no-untyped-def]
    """shift (MOST_TERMS, 2, WIDTH): coefficients of the correction that brings the crosses to their places.

    The terms x^b y^a stand in the order of a, then b, with a + b up to `degree`. cross (r): which of marks
    (s, 2, WIDTH) mm are crosses; places (s, 2) mm; work: a `Work`. The normal equations are moments, sums of
    x^b y^a, of which many products of two terms share one.
    """
    align_stack()
    power, moment, one, count = work.power, work.moment, same(1.0), len(cross)
    moment[: 2 * degree + 1, : 2 * degree + 1] = 0.0
    shift[: (degree + 1) * (degree + 2) // 2] = 0.0
    # two crosses at a time, for sums are written to memory each time; of an odd number the last comes with a zero
    for c in range(0, count, 2):
        s, z = cross[c], cross[min(c + 1, count - 1)]
        x, y, u, v = load(marks, s, 0), load(marks, s, 1), load(marks, z, 0), load(marks, z, 1)
        dx, dy, du, dv = places[s, 0] - x, places[s, 1] - y, places[z, 0] - u, places[z, 1] - v
        x, y, u, v = x * (1.0 / UNIT_MM), y * (1.0 / UNIT_MM), u * (1.0 / UNIT_MM), v * (1.0 / UNIT_MM)
        raised, other = one, one
        for b in range(2 * degree + 1):
            store(power, raised, b, 0)
            store(power, other, b, 1)
            raised, other = raised * x, other * u
        raised, other, term = one, same(1.0 if c + 1 < count else 0.0), 0
        for a in range(2 * degree + 1):
            for b in range(2 * degree + 1 - a):
                both = raised * load(power, b, 0) + other * load(power, b, 1)
                store(moment, load(moment, a, b) + both, a, b)
            for b in range(degree + 1 - a):
                own, its = raised * load(power, b, 0), other * load(power, b, 1)
                store(shift, load(shift, term, 0) + (own * dx + its * du), term, 0)
                store(shift, load(shift, term, 1) + (own * dy + its * dv), term, 1)
                term += 1
            raised, other = raised * y, other * v
    i = 0
    for a in range(degree + 1):
        for b in range(degree + 1 - a):
            j = 0
            for c in range(a + 1):
                for d in range(degree + 1 - c):
                    if j <= i:
                        store(work.normal, load(moment, a + c, b + d), i, j)
                    j += 1
            i += 1
    solve_normal(i, work.normal, shift)


@inlined
def without_shift(degree, shift, tile, x, y):  # type: ignore[no-untyped-def]
    """Lanes (x, y) mm with the correction that `fit_reseau` has found, by Horner's scheme."""
    u, v = x * (1.0 / UNIT_MM), y * (1.0 / UNIT_MM)
    dx, dy, term = same(0.0), same(0.0), (degree + 1) * (degree + 2) // 2
    for terms in range(1, degree + 2):
        along_x, along_y = same(0.0), same(0.0)
        for _ in range(terms):
            term -= 1
            along_x, along_y = along_x * u + load(shift, tile, term, 0), along_y * u + load(shift, tile, term, 1)
        dx, dy = dx * v + along_x, dy * v + along_y
    return x + dx, y + dy
