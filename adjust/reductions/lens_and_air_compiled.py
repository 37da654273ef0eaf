"""Lens and air taken out of single image coordinates, in compiled code.

Readable form: `adjust.reductions.reduction.through_lens_and_air`. Agreement: `tests/agreement/test_measured_trials.py`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from adjust.reductions.lens import TO_HARMONICS, half_diagonals
from simfield.block import Floats, Indices
from simfield.numerics import kernel

ROOT_2 = float(np.sqrt(2.0))


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


@kernel
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
