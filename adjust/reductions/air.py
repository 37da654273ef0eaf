"""Refraction and earth curvature taken out of vertical photographs; heights in metres, image by image.

Bertram's formula for the ARDC atmosphere gives the angle K tan(t) by which a ray at t from the nadir is bent. Against
rays traced through the ICAO atmosphere K is 17 to 19 % too small for the flights of 1980 (16.4 and 9.0 instead of 19.7
and 11.1 urad), and over high ground (camera 6 km, ground 4 km) 31 instead of 17.6 urad. It is the formula of the time
and of textbooks; what it leaves is a figure of `simfield budget`.

A sphere of radius R falls by s^2 / 2R under its tangent plane at the distance s, which draws its image inward.
"""

from __future__ import annotations

import numpy as np

from adjust.reductions.reduced_points import Reduced
from simfield.block import Floats, Indices

MEAN_RADIUS_M = 6371e3


def bending(camera_m: Floats, ground_m: Floats) -> Floats:
    """K in radians for heights above sea level: the bending of a ray at 45 degrees.

    K = [2410 H / (H^2 - 6H + 250) - 2410 h / (h^2 - 6h + 250) * h / H] 1e-6, H and h in km.
    """
    upper, lower = 1e-3 * np.asarray(camera_m), 1e-3 * np.asarray(ground_m)

    def column(z: Floats) -> Floats:
        return np.asarray(2410.0 * z / (z * (z - 6.0) + 250.0))

    return np.asarray(1e-6 * (column(upper) - column(lower) * lower / upper))


def refraction(xy: Floats, image: Indices, c_mm: Floats, camera_m: Floats, ground_m: Floats) -> Reduced:
    """Points xy (k, 2) in the images (k); c, heights of camera and ground (m). The image lay too far outside."""
    tangent_squared = (xy**2).sum(axis=1) / c_mm[image] ** 2
    outward = bending(camera_m, ground_m)[image] * (1.0 + tangent_squared)
    return Reduced.by(xy, xy - outward[:, None] * xy)


def earth_curvature(xy: Floats, image: Indices, c_mm: Floats, camera_m: Floats, ground_m: Floats) -> Reduced:
    """Points xy (k, 2) in the images (k); c, heights of camera and ground (m). The image lay too far inside."""
    tangent_squared = (xy**2).sum(axis=1) / c_mm[image] ** 2
    inward = 0.5 * (camera_m - ground_m)[image] / MEAN_RADIUS_M * tangent_squared
    return Reduced.by(xy, xy * (1.0 + inward)[:, None])
