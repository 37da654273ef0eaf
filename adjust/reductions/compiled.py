"""Reductions of some tiles of trials, in lanes: drift, comparator, inner orientation and reseau, image by image.

Readable forms: `adjust.reductions.comparator`, `.inner`, `.reseau`. The marks of an image are taken first, and say what
is done to its points (`oriented`); then points are reduced one by one (`reduced`). The arithmetic of a trial does not
depend on its neighbours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adjust.reductions.compiled_equations import (
    MOST_DEGREE,
    MOST_POWERS,
    MOST_TERMS,
    add_row,
    fit_reseau,
    solve_normal,
    without_shift,
)
from adjust.reductions.inner import PARAMETERS, UNIT_MM, Kind
from simfield.block import Floats, Indices
from simfield.lanes import WIDTH, Arena, align_stack, load, root, same, store
from simfield.lanes_compiled import inlined, kernel

KINDS: tuple[Kind, ...] = tuple(PARAMETERS)
HELMERT, AFFINE, BILINEAR, PROJECTIVE = range(4)
NO_KIND = -1
PROJECTIVE_STEPS = 3
"""the affine start is wrong by hundredths of a millimetre, so Gauss-Newton is at rounding after three steps"""
MOST_LINEAR = 4
RATE, CENTRE, ROWS = 8, 10, 12
"""rows of what is known of an image: parameters of X in 0 .. 3 and of Y in 4 .. 7 (projective: g in 3 and h in 7), the
drift a unit of time in x and y, the centre of the fiducials in x and y"""


class Frame(NamedTuple):
    """How images are reduced. The s settings of marks stand in the same order in every image.

    drift_weight (m, s): of the settings in an image's drift, 1/mm; 0 where no drift is taken out. by_x, by_y: one over
    the scales of the machine, and its shear; 1, 1, 0 where it is not calibrated. kind: of the inner orientation,
    NO_KIND for none; fiducial (f) settings it is found by. places (m, s, 2) mm of the marks. degree: of the reseau
    correction, 0 for none; cross (r): settings it is found by.
    """

    drift_weight: Floats
    by_x: float
    by_y: float
    shear: float
    kind: int
    fiducial: Indices
    places: Floats
    degree: int
    cross: Indices

    @classmethod
    def of(
        cls, kind: Kind, drift_weight: Floats, machine: tuple[float, float, float], places: Floats,
        fiducial: Indices, degree: int, cross: Indices,
    ) -> Frame:  # fmt: skip
        """machine: scales in x and y, and shear, all 0 where it is not calibrated; degree 0: no reseau correction.

        Raises ValueError for too few fiducials or crosses, and for a degree that normal equations cannot bear.
        """
        if 2 * len(fiducial) < PARAMETERS[kind]:
            raise ValueError(f"{kind} needs {PARAMETERS[kind] // 2} fiducials, there are {len(fiducial)} settings")
        if degree > MOST_DEGREE:
            raise ValueError(f"for many trials the degree of the reseau correction is at most {MOST_DEGREE}")
        terms = (degree + 1) * (degree + 2) // 2
        if degree > 0 and len(cross) < terms:
            raise ValueError(f"degree {degree} needs {terms} crosses, there are {len(cross)}")
        x, y, shear = machine
        return cls(
            drift_weight, 1.0 / (1.0 + x), 1.0 / (1.0 + y), shear, KINDS.index(kind), fiducial, places, degree, cross
        )

    @classmethod
    def nothing_reduced(cls, images: int, settings: int) -> Frame:
        """Machine coordinates are left as they are."""
        none = np.zeros(0, dtype=np.intp)
        weights, places = np.zeros((images, settings)), np.zeros((images, settings, 2))
        return cls(weights, 1.0, 1.0, 0.0, NO_KIND, none, places, 0, none)


class Work(NamedTuple):
    """Room for the equations of an image and a tile, and what is found for all tiles.

    known (tiles, ROWS, WIDTH) and shift (tiles, MOST_TERMS, 2, WIDTH), the correction by the reseau, are found.
    """

    known: Floats
    shift: Floats
    normal: Floats
    gradient: Floats
    row: Floats
    power: Floats
    right: Floats
    moment: Floats

    @classmethod
    def of(cls, tiles: int, arena: Arena) -> Work:
        """For so many tiles."""
        return cls(
            arena.zeros(tiles, ROWS, WIDTH),
            arena.zeros(tiles, MOST_TERMS, 2, WIDTH),
            arena.zeros(MOST_TERMS, MOST_TERMS, WIDTH),
            arena.zeros(MOST_LINEAR, 2, WIDTH),
            arena.zeros(MOST_LINEAR, WIDTH),
            arena.zeros(MOST_POWERS, 2, WIDTH),
            arena.zeros(2, WIDTH),
            arena.zeros(MOST_POWERS, MOST_POWERS, WIDTH),
        )


def drift_weights(image: Indices, mark: Indices, time: Floats, images: int) -> Floats:
    """(m, s): the drift of an image is the sum of these times its settings. See `adjust.reductions.drift`."""
    of_image = [np.flatnonzero(image == i) for i in range(images)]
    weights = np.zeros((images, len(of_image[0])))
    for i, rows in enumerate(of_image):
        _, owner, count = np.unique(mark[rows], return_inverse=True, return_counts=True)
        centred = time[rows] - (np.bincount(owner, time[rows]) / count)[owner]
        square = float(centred @ centred)
        weights[i] = centred / square if square > 0.0 else 0.0
    return weights


@kernel
def oriented(i, frame, mark_time, marks, work):  # type: ignore[no-untyped-def]
    """Find what is known of image i from marks (tiles, s, 2, WIDTH), mm on the machine, which are reduced in place."""
    align_stack()
    for tile in range(marks.shape[0]):
        known, own = work.known[tile], marks[tile]
        known[:] = 0.0
        rate_x, rate_y = load(known, RATE), load(known, RATE + 1)
        for s in range(len(mark_time)):
            w = frame.drift_weight[i, s]
            if w != 0.0:
                rate_x, rate_y = rate_x + w * load(own, s, 0), rate_y + w * load(own, s, 1)
        store(known, rate_x, RATE)
        store(known, rate_y, RATE + 1)
        if frame.kind == NO_KIND:
            continue
        centre_x, centre_y, share = load(known, CENTRE), load(known, CENTRE + 1), 1.0 / len(frame.fiducial)
        for s in range(len(mark_time)):
            x, y = _rectangular(frame, work.known, tile, mark_time[s], load(own, s, 0), load(own, s, 1))
            store(own, x, s, 0)
            store(own, y, s, 1)
        for s in frame.fiducial:
            centre_x, centre_y = centre_x + share * load(own, s, 0), centre_y + share * load(own, s, 1)
        store(known, centre_x, CENTRE)
        store(known, centre_y, CENTRE + 1)
        for s in range(len(mark_time)):
            store(own, (load(own, s, 0) - centre_x) * (1.0 / UNIT_MM), s, 0)
            store(own, (load(own, s, 1) - centre_y) * (1.0 / UNIT_MM), s, 1)
        _find_parameters(frame.kind, frame.fiducial, frame.places[i], own, known, work)
        if frame.degree > 0:
            for s in frame.cross:
                x, y = _transformed(frame.kind, work.known, tile, load(own, s, 0), load(own, s, 1))
                store(own, x, s, 0)
                store(own, y, s, 1)
            fit_reseau(frame.degree, frame.cross, frame.places[i], own, work, work.shift[tile])


@inlined
def reduced(frame, time, x, y, tile, work):  # type: ignore[no-untyped-def]
    """Lanes (x, y) mm of a point on the machine, set at `time`, in the frame of the marks of its image."""
    x, y = _rectangular(frame, work.known, tile, time, x, y)
    if frame.kind != NO_KIND:
        x, y = (
            (x - load(work.known, tile, CENTRE)) * (1.0 / UNIT_MM),
            (y - load(work.known, tile, CENTRE + 1)) * (1.0 / UNIT_MM),
        )
        x, y = _transformed(frame.kind, work.known, tile, x, y)
        if frame.degree > 0:
            x, y = without_shift(frame.degree, work.shift, tile, x, y)
    return x, y


@inlined
def _rectangular(frame, known, tile, time, x, y):  # type: ignore[no-untyped-def]
    """Lanes (x, y) without drift, on rectangular axes of true scale."""
    y = (y - time * load(known, tile, RATE + 1)) * frame.by_y
    return ((x - time * load(known, tile, RATE)) - frame.shear * y) * frame.by_x, y


@inlined
def _transformed(kind, known, tile, x, y):  # type: ignore[no-untyped-def]
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
def _find_parameters(kind, fiducial, places, marks, known, work):  # type: ignore[no-untyped-def]
    """Parameters into known (ROWS, WIDTH) from marks (s, 2, WIDTH) in UNIT_MM and their places (s, 2) mm."""
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
