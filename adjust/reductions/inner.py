"""Inner orientation: from machine to image coordinates by the fiducial marks, image by image, by least squares.

    helmert      X = a x - b y + c,  Y = b x + a y + d
    affine       X = a x + b y + c,  Y likewise
    bilinear     X = a x + b y + c + d x y,  Y likewise
    projective   X = (a x + b y + c) / (g x + h y + 1),  Y likewise with the same denominator

Machine coordinates are reduced to the centre of the marks and to 100 mm before anything is solved.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from adjust.reductions.reduced_points import Reduced
from simfield.block import Floats, Indices

Kind = Literal["helmert", "affine", "bilinear", "projective"]
PARAMETERS: dict[Kind, int] = {"helmert": 4, "affine": 6, "bilinear": 8, "projective": 8}
UNIT_MM = 100.0
PROJECTIVE_STEPS = 6


@dataclass(frozen=True, eq=False)
class InnerOrientation:
    """parameters (m, p) of every image; residuals (f, 2), mm, calibrated minus transformed; redundancy (m).

    sigma0_um (m): the standard deviation of a fiducial coordinate; NaN where there is no redundancy.
    """

    kind: Kind
    parameters: Floats
    centre: Floats
    residuals: Floats
    redundancy: Indices
    sigma0_um: Floats

    @property
    def rms_um(self) -> float:
        """The quadratic mean of sigma0_um over the images that have one; NaN where none has."""
        known = self.sigma0_um[np.isfinite(self.sigma0_um)]
        return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")

    def apply(self, xy: Floats, image: Indices) -> Reduced:
        """Points xy (k, 2) of the images (k) in the frame of the calibrated marks."""
        return Reduced.by(xy, _transformed(self.kind, self.parameters[image], _reduced(xy, self.centre[image])))


def inner_orientation(
    kind: Kind, measured: Floats, calibrated: Floats, image: Indices, images: int
) -> InnerOrientation:
    """Fit every image by its fiducials: measured and calibrated (f, 2) mm in the images (f).

    Raises ValueError for an unknown kind and for an image with too few fiducials.
    """
    if kind not in PARAMETERS:
        raise ValueError(f"no inner orientation {kind!r}, allowed are {', '.join(PARAMETERS)}")
    count = np.bincount(image, minlength=images)
    if (2 * count < PARAMETERS[kind]).any():
        short = int(np.argmax(2 * count < PARAMETERS[kind]))
        raise ValueError(f"{kind} needs {PARAMETERS[kind] // 2} fiducials, image number {short} has {count[short]}")
    centre = np.stack([np.bincount(image, measured[:, a], minlength=images) / count for a in (0, 1)], axis=1)
    xy = _reduced(measured, centre[image])
    if kind == "projective":
        parameters = _projective(xy, calibrated, image, images)
    else:
        parameters = _solved(_design(kind, xy), calibrated, image, images)
    residuals = calibrated - _transformed(kind, parameters[image], xy)
    redundancy = 2 * count - PARAMETERS[kind]
    vv = np.bincount(image, (residuals**2).sum(axis=1), minlength=images)
    with np.errstate(divide="ignore", invalid="ignore"):
        sigma0 = np.where(redundancy > 0, 1000.0 * np.sqrt(vv / redundancy), np.nan)
    return InnerOrientation(kind, parameters, centre, residuals, redundancy, sigma0)


def _reduced(xy: Floats, centre: Floats) -> Floats:
    return np.asarray((xy - centre) / UNIT_MM)


def _design(kind: Kind, xy: Floats) -> Floats:
    """(f, 2, p) the derivatives of X and Y by the parameters of a transformation that is linear in them."""
    x, y = xy.T
    one, zero = np.ones_like(x), np.zeros_like(x)
    if kind == "helmert":
        return np.stack([np.stack([x, -y, one, zero], axis=1), np.stack([y, x, zero, one], axis=1)], axis=1)
    columns = [x, y, one] if kind == "affine" else [x, y, one, x * y]
    half = np.stack(columns, axis=1)
    nothing = np.zeros_like(half)
    return np.stack([np.concatenate([half, nothing], axis=1), np.concatenate([nothing, half], axis=1)], axis=1)


def _solved(design: Floats, right: Floats, image: Indices, images: int) -> Floats:
    """(m, p) least squares of design (f, 2, p) and right (f, 2), image by image."""
    p = design.shape[2]
    normal, gradient = np.zeros((images, p, p)), np.zeros((images, p))
    np.add.at(normal, image, design.transpose(0, 2, 1) @ design)
    np.add.at(gradient, image, np.einsum("fap,fa->fp", design, right))
    first = np.linalg.solve(normal, gradient[:, :, None])[:, :, 0]
    # one step of refinement wins back what squaring the design has cost
    left = right - np.einsum("fap,fp->fa", design, first[image])
    again = np.zeros_like(gradient)
    np.add.at(again, image, np.einsum("fap,fa->fp", design, left))
    return np.asarray(first + np.linalg.solve(normal, again[:, :, None])[:, :, 0])


def _transformed(kind: Kind, p: Floats, xy: Floats) -> Floats:
    """(k, 2): parameters p (k, p) applied to reduced coordinates (k, 2)."""
    if kind == "projective":
        x, y = xy.T
        below = p[:, 6] * x + p[:, 7] * y + 1.0
        above = np.stack([p[:, 0] * x + p[:, 1] * y + p[:, 2], p[:, 3] * x + p[:, 4] * y + p[:, 5]], axis=1)
        return np.asarray(above / below[:, None])
    return np.asarray(np.einsum("kap,kp->ka", _design(kind, xy), p))


def _projective(xy: Floats, calibrated: Floats, image: Indices, images: int) -> Floats:
    """(m, 8) by Gauss-Newton from the affine solution."""
    affine = _solved(_design("affine", xy), calibrated, image, images)
    p = np.concatenate([affine, np.zeros((images, 2))], axis=1)
    x, y = xy.T
    for _ in range(PROJECTIVE_STEPS):
        own = p[image]
        now = _transformed("projective", own, xy)
        below = (own[:, 6] * x + own[:, 7] * y + 1.0)[:, None, None]
        linear = _design("affine", xy) / below
        bent = -now[:, :, None] * xy[:, None, :] / below
        p = p + _solved(np.concatenate([linear, bent], axis=2), calibrated - now, image, images)
    return p
