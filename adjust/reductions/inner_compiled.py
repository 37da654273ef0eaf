"""Inner orientation of an image in some tiles of trials, in lanes.

The parameters of X stand in the rows 0 .. 3 of what is known of an image,
those of Y in 4 .. 7; of the projective transformation, g in 3 and h in 7.

Readable form: `adjust.reductions.inner`. Agreement: `tests/agreement/test_measured_trials.py`.
"""

from __future__ import annotations

from adjust.reductions.inner import PARAMETERS, Kind
from adjust.reductions.reseau_crosses_compiled import add_row, solve_normal
from simfield.numerics import align_stack, inlined, kernel, load, root, same, store

KINDS: tuple[Kind, ...] = tuple(PARAMETERS)
HELMERT, AFFINE, BILINEAR, PROJECTIVE = range(4)
PROJECTIVE_STEPS = 3
"""the affine start is wrong by hundredths of a millimetre, so Gauss-Newton is at rounding after three steps"""
MOST_LINEAR = 4


@inlined
def transformed(kind, known, tile, x, y):  # type: ignore[no-untyped-def]
    """Lanes (x, y), in UNIT_MM from the centre, in the frame of the marks, mm."""
    u = load(known, tile, 0) * x + load(known, tile, 1) * y + load(known, tile, 2)
    v = load(known, tile, 4) * x + load(known, tile, 5) * y + load(known, tile, 6)
    if kind == BILINEAR:
        u, v = u + load(known, tile, 3) * (x * y), v + load(known, tile, 7) * (x * y)
    elif kind == PROJECTIVE:
        below = 1.0 / (load(known, tile, 3) * x + load(known, tile, 7) * y + 1.0)
        u, v = u * below, v * below
    return u, v


@kernel
def find_parameters(kind, fiducial, places, marks, known, work):  # type: ignore[no-untyped-def]
    """Parameters into known (rows, WIDTH) from marks (s, 2, WIDTH) in UNIT_MM and their places (s, 2) mm."""
    if kind == HELMERT:
        _helmert(fiducial, places, marks, known)
        return
    _linear(4 if kind == BILINEAR else 3, fiducial, places, marks, known, work)
    if kind == PROJECTIVE:
        _projective(fiducial, places, marks, known)


@kernel
def _helmert(fiducial, places, marks, known):  # type: ignore[no-untyped-def]
    """X = a x - b y + c, Y = b x + a y + d over marks that are reduced to their centre."""
    align_stack()
    c, d = 0.0, 0.0
    for s in fiducial:
        c += places[s, 0] / len(fiducial)
        d += places[s, 1] / len(fiducial)
    along, across, square = same(0.0), same(0.0), same(0.0)
    for s in fiducial:
        u, v, x, y = places[s, 0] - c, places[s, 1] - d, load(marks, s, 0), load(marks, s, 1)
        along, across, square = along + (x * u + y * v), across + (x * v - y * u), square + (x * x + y * y)
    a, b = along / square, across / square
    store(known, a, 0)
    store(known, -b, 1)
    store(known, same(c), 2)
    store(known, b, 4)
    store(known, a, 5)
    store(known, same(d), 6)


@kernel
def _linear(terms, fiducial, places, marks, known, work):  # type: ignore[no-untyped-def]
    """X and Y each by the terms x, y, 1 and, with four terms, x y."""
    align_stack()
    work.normal[:MOST_LINEAR, :MOST_LINEAR] = 0.0
    work.gradient[:] = 0.0
    store(work.row, same(1.0), 2)
    for s in fiducial:
        x, y = load(marks, s, 0), load(marks, s, 1)
        store(work.row, x, 0)
        store(work.row, y, 1)
        store(work.row, x * y, 3)
        store(work.right, same(places[s, 0]), 0)
        store(work.right, same(places[s, 1]), 1)
        add_row(terms, work.row, work.right, work.normal, work.gradient)
    solve_normal(terms, work.normal, work.gradient)
    for j in range(terms):
        store(known, load(work.gradient, j, 0), j)
        store(known, load(work.gradient, j, 1), 4 + j)


@kernel
def _projective(fiducial, places, marks, known):  # type: ignore[no-untyped-def]
    """Gauss-Newton from affine parameters.

    Per mark, with e = (x, y, 1), b = 1 / (g x + h y + 1) and (X, Y) the transformed place, the rows of the Jacobian are
    b (e, 0, -X x, -X y) and b (0, e, -Y x, -Y y). So one matrix n = sum b^2 e e^T serves the parameters of X and of Y,
    which are eliminated; what is left for (g, h) is a matrix m of two rows.
    """
    align_stack()
    zero = same(0.0)
    for _ in range(PROJECTIVE_STEPS):
        n11, n12, n13, n22, n23, n33, m11, m12, m22 = zero, zero, zero, zero, zero, zero, zero, zero, zero
        x11, x12, x13, x22, x23, y11, y12, y13, y22, y23 = (
            zero, zero, zero, zero, zero, zero, zero, zero, zero, zero,
        )  # fmt: skip
        a1, a2, a3, b1, b2, b3, c1, c2 = zero, zero, zero, zero, zero, zero, zero, zero
        for s in fiducial:
            x, y = load(marks, s, 0), load(marks, s, 1)
            below = 1.0 / (load(known, 3) * x + load(known, 7) * y + 1.0)
            now_x = (load(known, 0) * x + load(known, 1) * y + load(known, 2)) * below
            now_y = (load(known, 4) * x + load(known, 5) * y + load(known, 6)) * below
            rest_x, rest_y = (places[s, 0] - now_x) * below, (places[s, 1] - now_y) * below
            square = below * below
            wx, wy = square * x, square * y
            xx, xy, yy = wx * x, wx * y, wy * y
            n11, n12, n13, n22, n23, n33 = n11 + xx, n12 + xy, n13 + wx, n22 + yy, n23 + wy, n33 + square
            x11, x12, x13 = x11 - now_x * xx, x12 - now_x * xy, x13 - now_x * wx
            x22, x23 = x22 - now_x * yy, x23 - now_x * wy
            y11, y12, y13 = y11 - now_y * xx, y12 - now_y * xy, y13 - now_y * wx
            y22, y23 = y22 - now_y * yy, y23 - now_y * wy
            both = now_x * now_x + now_y * now_y
            m11, m12, m22 = m11 + both * xx, m12 + both * xy, m22 + both * yy
            a1, a2, a3 = a1 + rest_x * x, a2 + rest_x * y, a3 + rest_x
            b1, b2, b3 = b1 + rest_y * x, b2 + rest_y * y, b3 + rest_y
            pull = now_x * rest_x + now_y * rest_y
            c1, c2 = c1 - pull * x, c2 - pull * y
        # Cholesky of n, whose diagonal is kept as reciprocals of the roots
        l11 = 1.0 / root(n11)
        l21, l31 = n12 * l11, n13 * l11
        l22 = 1.0 / root(n22 - l21 * l21)
        l32 = (n23 - l21 * l31) * l22
        l33 = 1.0 / root(n33 - l31 * l31 - l32 * l32)
        factor = (l11, l21, l22, l31, l32, l33)
        a1, a2, a3 = _forward(factor, a1, a2, a3)
        b1, b2, b3 = _forward(factor, b1, b2, b3)
        x1, x2, x3 = _forward(factor, x11, x12, x13)
        x4, x5, x6 = _forward(factor, x12, x22, x23)
        y1, y2, y3 = _forward(factor, y11, y12, y13)
        y4, y5, y6 = _forward(factor, y12, y22, y23)
        m11 = m11 - (x1 * x1 + x2 * x2 + x3 * x3) - (y1 * y1 + y2 * y2 + y3 * y3)
        m12 = m12 - (x1 * x4 + x2 * x5 + x3 * x6) - (y1 * y4 + y2 * y5 + y3 * y6)
        m22 = m22 - (x4 * x4 + x5 * x5 + x6 * x6) - (y4 * y4 + y5 * y5 + y6 * y6)
        c1 = c1 - (x1 * a1 + x2 * a2 + x3 * a3) - (y1 * b1 + y2 * b2 + y3 * b3)
        c2 = c2 - (x4 * a1 + x5 * a2 + x6 * a3) - (y4 * b1 + y5 * b2 + y6 * b3)
        by_determinant = 1.0 / (m11 * m22 - m12 * m12)
        g, h = (m22 * c1 - m12 * c2) * by_determinant, (m11 * c2 - m12 * c1) * by_determinant
        a1, a2, a3 = _backward(factor, a1 - x1 * g - x4 * h, a2 - x2 * g - x5 * h, a3 - x3 * g - x6 * h)
        b1, b2, b3 = _backward(factor, b1 - y1 * g - y4 * h, b2 - y2 * g - y5 * h, b3 - y3 * g - y6 * h)
        change = (a1, a2, a3, g, b1, b2, b3, h)
        for j in range(len(change)):
            store(known, load(known, j) + change[j], j)


@inlined
def _forward(factor, a, b, c):  # type: ignore[no-untyped-def]
    """L^-1 (a, b, c); factor: L by rows, with reciprocal diagonal."""
    a = a * factor[0]
    b = (b - factor[1] * a) * factor[2]
    return a, b, (c - factor[3] * a - factor[4] * b) * factor[5]


@inlined
def _backward(factor, a, b, c):  # type: ignore[no-untyped-def]
    """L^-T (a, b, c)."""
    c = c * factor[5]
    b = (b - factor[4] * c) * factor[2]
    return (a - factor[1] * b - factor[3] * c) * factor[0], b, c
