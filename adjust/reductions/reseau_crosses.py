"""Reseau correction: the deformation that calibrated crosses show, taken out of the points of the same image."""

from __future__ import annotations

import numpy as np

from adjust.reductions.reduced_points import Reduced
from simfield.block import Floats, Indices

UNIT_MM = 100.0


def reseau(
    xy: Floats, image: Indices, crosses: Floats, calibrated: Floats, cross_image: Indices, degree: int = 3
) -> Reduced:
    """Points xy (k, 2) of the images (k) corrected by polynomials of a degree through measured crosses (r, 2).

    crosses and points stand in the same frame; calibrated (r, 2) says where the crosses are. Raises ValueError for an
    image with fewer crosses than the polynomial has terms.
    """
    corrected = np.array(xy)
    for i in np.unique(image):
        own, of_image = image == i, cross_image == i
        terms = _monomials(crosses[of_image], degree)
        if len(terms) < terms.shape[1]:
            raise ValueError(f"degree {degree} needs {terms.shape[1]} crosses, image number {i} has {len(terms)}")
        shift, *_ = np.linalg.lstsq(terms, calibrated[of_image] - crosses[of_image], rcond=None)
        corrected[own] += _monomials(xy[own], degree) @ shift
    return Reduced.by(xy, corrected)


def _monomials(xy: Floats, degree: int) -> Floats:
    x, y = (xy / UNIT_MM).T
    return np.column_stack([x ** (d - j) * y**j for d in range(degree + 1) for j in range(d + 1)])
