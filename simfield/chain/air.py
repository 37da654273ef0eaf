"""Refraction and earth curvature, image by image with its own flying height; effects are those of
simfield.disturbances.effects.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simfield.block import Floats, Indices
from simfield.disturbances import EarthCurvature, Refraction, measured_from_ideal


@dataclass(frozen=True)
class Air:
    """Which of the two the field has; altimeter_sigma_m is the error of the flying height that the surveyor is told.

    Rays are traced through the standard atmosphere; the reductions take out a formula, so that something is left.
    """

    refraction: bool = False
    curvature: bool = False
    altimeter_sigma_m: float = 0.0


def through_air(air: Air, ideal: Floats, image: Indices, heights_m: Floats, ground_m: float, c_mm: Floats) -> Floats:
    """(k, 2) mm: ideal points (k, 2) in the images (k) after curvature, then refraction; heights and c (m)."""
    xy = np.array(ideal)
    for i in range(len(heights_m)):
        own = image == i
        if air.curvature:
            curvature = EarthCurvature(float(heights_m[i]) - ground_m, float(c_mm[i]))
            xy[own] = measured_from_ideal(xy[own], curvature.displacement)
        if air.refraction:
            refraction = Refraction(float(heights_m[i]), ground_m, float(c_mm[i]))
            xy[own] = measured_from_ideal(xy[own], refraction.displacement)
    return xy
