"""Reductions of a block of trials of one image, in compiled loops: drift, comparator, inner orientation, reseau,
lens and air.

Readable forms: `adjust.reductions.comparator`, `.inner`, `.reseau`, `.lens`, `.air`. Trials are the last, contiguous
axis; least squares are solved by normal equations in all of them at once, and the arithmetic of a trial does not depend
on its neighbours.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numba
import numpy as np

from adjust.reductions.inner import PARAMETERS, UNIT_MM, Kind
from adjust.reductions.lens import TO_HARMONICS, half_diagonals
from simfield.block import Floats, Indices

KINDS: tuple[Kind, ...] = tuple(PARAMETERS)
HELMERT, AFFINE, BILINEAR, PROJECTIVE = range(4)
NO_KIND = -1
ROOT_2 = float(np.sqrt(2.0))
PROJECTIVE_STEPS = 3
"""the affine start is wrong by hundredths of a millimetre, so Gauss-Newton is at rounding after three steps"""
EACH = np.arange(21)
OF_X, OF_Y = np.array([0, 1, 2, 3, 7]), np.array([3, 4, 5, 6, 7])
"""the parameters of the projective transformation that act on X and on Y"""
MOST_DEGREE = 5
"""normal equations of higher polynomials lose too many digits"""


class Frame(NamedTuple):
    """How images are reduced. The s settings of marks stand in the same order in every image.

    drift_weight (m, s): of the settings in an image's drift, 1/mm; 0 where no drift is taken out. scale_x, scale_y,
    shear: of the machine, 0 where it is not calibrated. kind: of the inner orientation, NO_KIND for none; fiducial
    (f) settings it is found by. places (m, s, 2) mm of the marks. degree: of the reseau correction, 0 for none; cross
    (r): settings it is found by.
    """

    drift_weight: Floats
    scale_x: float
    scale_y: float
    shear: float
    kind: int
    fiducial: Indices
    places: Floats
    degree: int
    cross: Indices


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


@numba.njit(cache=True, error_model="numpy")
def reduce_image(i, frame, time, mark_time, xy, marks):  # type: ignore[no-untyped-def]
    """xy (n, 2, T) and marks (s, 2, T), mm, of image i are reduced in place; time (n), mark_time (s)."""
    lanes = xy.shape[2]
    rate, centre = np.zeros((2, lanes)), np.zeros((2, lanes))
    for s in range(len(mark_time)):
        w = frame.drift_weight[i, s]
        if w != 0.0:
            for t in range(lanes):
                rate[0, t] += w * marks[s, 0, t]
                rate[1, t] += w * marks[s, 1, t]
    by_x, by_y, shear = 1.0 / (1.0 + frame.scale_x), 1.0 / (1.0 + frame.scale_y), frame.shear
    _rectangular(by_x, by_y, shear, rate, centre, mark_time, marks)
    if frame.kind == NO_KIND:
        _rectangular(by_x, by_y, shear, rate, centre, time, xy)
        return
    for s in frame.fiducial:
        for t in range(lanes):
            centre[0, t] += marks[s, 0, t] / len(frame.fiducial)
            centre[1, t] += marks[s, 1, t] / len(frame.fiducial)
    for s in range(len(mark_time)):
        for t in range(lanes):
            marks[s, 0, t] = (marks[s, 0, t] - centre[0, t]) / UNIT_MM
            marks[s, 1, t] = (marks[s, 1, t] - centre[1, t]) / UNIT_MM
    p = _parameters(frame.kind, frame.fiducial, frame.places[i], marks)
    _apply(frame.kind, p, xy, by_x, by_y, shear, rate, centre, time, 1.0 / UNIT_MM)
    if frame.degree > 0:
        still = np.zeros((2, lanes))
        _apply(frame.kind, p, marks, 1.0, 1.0, 0.0, still, still, mark_time, 1.0)
        _reseau(frame.degree, frame.cross, frame.places[i], xy, marks)


@numba.njit(cache=True, error_model="numpy")
def _rectangular(by_x, by_y, shear, rate, centre, time, xy):  # type: ignore[no-untyped-def]
    """xy (n, 2, T) in place: without drift, on rectangular axes of true scale, and reckoned from a centre."""
    for row in range(len(xy)):
        at = time[row]
        for t in range(xy.shape[2]):
            y = (xy[row, 1, t] - at * rate[1, t]) * by_y
            xy[row, 0, t] = ((xy[row, 0, t] - at * rate[0, t]) - shear * y) * by_x - centre[0, t]
            xy[row, 1, t] = y - centre[1, t]


@numba.njit(cache=True, error_model="numpy")
def _parameters(kind, fiducial, places, marks):  # type: ignore[no-untyped-def]
    """(8, T): those of X in [0:4], of Y in [4:8]; projective: g and h in [3] and [7]. marks (s, 2, T) in UNIT_MM."""
    if kind == HELMERT:
        return _helmert(fiducial, places, marks)
    p = _linear(4 if kind == BILINEAR else 3, fiducial, places, marks)
    return _projective(p, fiducial, places, marks) if kind == PROJECTIVE else p


@numba.njit(cache=True, error_model="numpy")
def _apply(kind, p, xy, by_x, by_y, shear, rate, centre, time, unit):  # type: ignore[no-untyped-def]
    """xy (n, 2, T) in place: as `_rectangular`, times unit, and transformed by p (8, T), all in one pass."""
    for row in range(len(xy)):
        at = time[row]
        for t in range(xy.shape[2]):
            y = (xy[row, 1, t] - at * rate[1, t]) * by_y
            x = (((xy[row, 0, t] - at * rate[0, t]) - shear * y) * by_x - centre[0, t]) * unit
            y = (y - centre[1, t]) * unit
            u, v = p[0, t] * x + p[1, t] * y + p[2, t], p[4, t] * x + p[5, t] * y + p[6, t]
            if kind == BILINEAR:
                u, v = u + p[3, t] * x * y, v + p[7, t] * x * y
            elif kind == PROJECTIVE:
                below = 1.0 / (p[3, t] * x + p[7, t] * y + 1.0)
                u, v = u * below, v * below
            xy[row, 0, t], xy[row, 1, t] = u, v


@numba.njit(cache=True, error_model="numpy")
def _helmert(fiducial, places, marks):  # type: ignore[no-untyped-def]
    """X = a x - b y + c, Y = b x + a y + d over marks that are reduced to their centre."""
    lanes = marks.shape[2]
    p = np.zeros((8, lanes))
    c, d = 0.0, 0.0
    for s in fiducial:
        c += places[s, 0] / len(fiducial)
        d += places[s, 1] / len(fiducial)
    square = np.zeros(lanes)
    for s in fiducial:
        u, v = places[s, 0] - c, places[s, 1] - d
        for t in range(lanes):
            x, y = marks[s, 0, t], marks[s, 1, t]
            p[0, t] += x * u + y * v
            p[4, t] += x * v - y * u
            square[t] += x * x + y * y
    for t in range(lanes):
        a, b = p[0, t] / square[t], p[4, t] / square[t]
        p[0, t], p[1, t], p[2, t] = a, -b, c
        p[4, t], p[5, t], p[6, t] = b, a, d
    return p


@numba.njit(cache=True, error_model="numpy")
def _linear(terms, fiducial, places, marks):  # type: ignore[no-untyped-def]
    """X and Y each by the terms x, y, 1 and, with four terms, x y."""
    lanes = marks.shape[2]
    row, right = np.empty((terms, lanes)), np.empty((2, lanes))
    normal, gradient = np.zeros((terms, terms, lanes)), np.zeros((terms, 2, lanes))
    for s in fiducial:
        for t in range(lanes):
            row[0, t], row[1, t], row[2, t] = marks[s, 0, t], marks[s, 1, t], 1.0
            if terms == 4:
                row[3, t] = marks[s, 0, t] * marks[s, 1, t]
            right[0, t], right[1, t] = places[s, 0], places[s, 1]
        _add(EACH[:terms], row, right, normal, gradient)
    solve_lanes(normal, gradient)
    p = np.zeros((8, lanes))
    for j in range(terms):
        p[j], p[4 + j] = gradient[j, 0], gradient[j, 1]
    return p


@numba.njit(cache=True, error_model="numpy")
def _projective(p, fiducial, places, marks):  # type: ignore[no-untyped-def]
    """Gauss-Newton from affine parameters p (8, T)."""
    lanes = marks.shape[2]
    row, right = np.empty((8, lanes)), np.empty((1, lanes))
    for _ in range(PROJECTIVE_STEPS):
        normal, gradient = np.zeros((8, 8, lanes)), np.zeros((8, 1, lanes))
        for s in fiducial:
            for axis in range(2):
                first = 4 * axis
                for t in range(lanes):
                    x, y = marks[s, 0, t], marks[s, 1, t]
                    below = 1.0 / (p[3, t] * x + p[7, t] * y + 1.0)
                    now = (p[first, t] * x + p[first + 1, t] * y + p[first + 2, t]) * below
                    row[first, t], row[first + 1, t], row[first + 2, t] = x * below, y * below, below
                    row[3, t], row[7, t] = -now * x * below, -now * y * below
                    right[0, t] = places[s, axis] - now
                _add(OF_X if axis == 0 else OF_Y, row, right, normal, gradient)
        solve_lanes(normal, gradient)
        p += gradient[:, 0]
    return p


@numba.njit(cache=True, error_model="numpy")
def _reseau(degree, cross, places, xy, marks):  # type: ignore[no-untyped-def]
    """Correct xy in place by polynomials through the crosses; see `adjust.reductions.reseau`."""
    lanes = xy.shape[2]
    terms = (degree + 1) * (degree + 2) // 2
    row, right = np.empty((terms, lanes)), np.empty((2, lanes))
    normal, shift = np.zeros((terms, terms, lanes)), np.zeros((terms, 2, lanes))
    for s in cross:
        _monomials(degree, marks, s, row)
        for t in range(lanes):
            right[0, t], right[1, t] = places[s, 0] - marks[s, 0, t], places[s, 1] - marks[s, 1, t]
        _add(EACH[:terms], row, right, normal, shift)
    solve_lanes(normal, shift)
    for at in range(len(xy)):
        _monomials(degree, xy, at, row)
        for j in range(terms):
            for axis in range(2):
                for t in range(lanes):
                    xy[at, axis, t] += row[j, t] * shift[j, axis, t]


@numba.njit(cache=True, error_model="numpy")
def _monomials(degree, xy, at, row):  # type: ignore[no-untyped-def]
    """row (terms, T): 1, x, y, x^2, xy, y^2 ... of xy[at] (2, T) in units of UNIT_MM."""
    lanes = xy.shape[2]
    row[0] = 1.0
    for d in range(1, degree + 1):
        begin, before = d * (d + 1) // 2, (d - 1) * d // 2
        for j in range(d + 1):
            axis, of = (1, before + j - 1) if j == d else (0, before + j)
            for t in range(lanes):
                row[begin + j, t] = row[of, t] * (xy[at, axis, t] / UNIT_MM)


@numba.njit(cache=True, error_model="numpy")
def _add(columns, row, right, normal, gradient):  # type: ignore[no-untyped-def]
    """normal (p, p, T) += row row^T, the lower triangle alone; gradient (p, w, T) += row right^T (w, T).

    columns: those of row (p, T) that are not 0, in rising order.
    """
    lanes = row.shape[1]
    for a in range(len(columns)):
        i = columns[a]
        for b in range(a + 1):
            j = columns[b]
            for t in range(lanes):
                normal[i, j, t] += row[i, t] * row[j, t]
        for w in range(len(right)):
            for t in range(lanes):
                gradient[i, w, t] += row[i, t] * right[w, t]


@numba.njit(cache=True, error_model="numpy")
def solve_lanes(normal, right):  # type: ignore[no-untyped-def]
    """right (p, w, T) becomes normal^-1 right in every trial, by Cholesky; of normal (p, p, T) the lower triangle."""
    p, lanes = len(normal), normal.shape[2]
    for i in range(p):
        for j in range(i):
            for k in range(j):
                for t in range(lanes):
                    normal[i, j, t] -= normal[i, k, t] * normal[j, k, t]
            for t in range(lanes):
                normal[i, j, t] *= normal[j, j, t]
        for k in range(i):
            for t in range(lanes):
                normal[i, i, t] -= normal[i, k, t] * normal[i, k, t]
        # the diagonal holds the reciprocal of the root
        for t in range(lanes):
            normal[i, i, t] = 1.0 / np.sqrt(normal[i, i, t])
    for w in range(right.shape[1]):
        for i in range(p):
            for k in range(i):
                for t in range(lanes):
                    right[i, w, t] -= normal[i, k, t] * right[k, w, t]
            for t in range(lanes):
                right[i, w, t] *= normal[i, i, t]
        for i in range(p - 1, -1, -1):
            for k in range(i + 1, p):
                for t in range(lanes):
                    right[i, w, t] -= normal[k, i, t] * right[k, w, t]
            for t in range(lanes):
                right[i, w, t] *= normal[i, i, t]


class Optics(NamedTuple):
    """What lens and air do in each image, for `without_lens_and_air`.

    begin (m), end (m): the intervals of the certificate of an image's lens, none if there is none; knot (q) mm where
    they begin, last (m) mm where the certificate ends; spline (q, 4, 4): powers 3 to 0 of r - knot, mm, of the mean, of
    cosine and sine of the angle from the first half-diagonal, and of the cosine of twice that angle. bending (m) and
    inward (m): refraction and curvature, 0 where they are not taken out; c_mm (m).
    """

    begin: Indices
    end: Indices
    knot: Floats
    last: Floats
    spline: Floats
    bending: Floats
    inward: Floats
    c_mm: Floats


def optics(
    certificates: Mapping[int, tuple[Floats, Floats]], camera: Indices, bending: Floats, inward: Floats, c_mm: Floats
) -> Optics:
    """certificates: radii (r) mm and distortions (4 or 1, r) um by number of the camera; camera (m) of each image."""
    knots, splines, places = [np.zeros(0)], [np.zeros((0, 4, 4))], {}
    for number, (radius_mm, distortion_um) in certificates.items():
        spline = half_diagonals(radius_mm, distortion_um)
        first = sum(len(k) for k in knots)
        places[number] = (first, first + len(spline.x) - 1, float(radius_mm[-1]))
        knots.append(spline.x[:-1])
        # (4 powers, q, 4 curves) to (q, 4 harmonics, 4 powers)
        splines.append(np.einsum("hc,pqc->qhp", TO_HARMONICS, spline.c))
    none = (0, 0, np.inf)
    rows = [places.get(number, none) for number in camera.tolist()]
    return Optics(
        np.array([row[0] for row in rows], dtype=np.intp),
        np.array([row[1] for row in rows], dtype=np.intp),
        np.concatenate(knots),
        np.array([row[2] for row in rows], dtype=float),
        np.concatenate(splines),
        bending,
        inward,
        c_mm,
    )


@numba.njit(cache=True, error_model="numpy")
def without_lens_and_air(i, optics, x, y):  # type: ignore[no-untyped-def]
    """(x, y) mm of image i without lens errors, refraction and curvature; NaN beyond the certificate.

    See `adjust.reductions.radial`, `.refraction`, `.earth_curvature`.
    """
    if optics.begin[i] < optics.end[i]:
        r = np.sqrt(x * x + y * y)
        if r > optics.last[i]:
            return np.nan, np.nan
        if r > 0.0:
            q = optics.begin[i]
            while q + 1 < optics.end[i] and optics.knot[q + 1] <= r:
                q += 1
            cosine, sine = (x + y) / (ROOT_2 * r), (y - x) / (ROOT_2 * r)
            amount, t = 0.0, r - optics.knot[q]
            for h in range(4):
                c = optics.spline[q, h]
                by = 1.0 if h == 0 else cosine if h == 1 else sine if h == 2 else cosine * cosine - sine * sine
                amount += by * (((c[0] * t + c[1]) * t + c[2]) * t + c[3])
            x, y = x * (1.0 - amount / r), y * (1.0 - amount / r)
    square = optics.c_mm[i] * optics.c_mm[i]
    out = 1.0 - optics.bending[i] * (1.0 + (x * x + y * y) / square)
    x, y = x * out, y * out
    back = 1.0 + optics.inward[i] * ((x * x + y * y) / square)
    return x * back, y * back


def frame_kind(kind: Kind) -> int:
    """The number of a kind of inner orientation."""
    return KINDS.index(kind)


def nothing_reduced(images: int, settings: int) -> Any:
    """A frame that leaves machine coordinates as they are."""
    none = np.zeros(0, dtype=np.intp)
    return Frame(np.zeros((images, settings)), 0.0, 0.0, 0.0, NO_KIND, none, np.zeros((images, settings, 2)), 0, none)
