"""Lesson 2: why a second zero crossing? The correlation of flying height and radial distortion in the block of 1980.

Model 3.1 of Mauelshagen 1980: dx = x [a3 (r^2 - r0^2) + a4 (r^4 - r0^4)] + ..., dy alike. A change of r0 adds
a multiple
of (x, y) to each term, which over flat ground is a change of the flying height Z0. So r0 changes the names of things
and no thing: residuals, points and sigma0 stay what they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust import ap_models, correlations
from simfield import Block, presets, simulate
from simfield.block import Floats
from simfield.numerics import one_thread
from studies.experiments.mauelshagen_1980 import middle_images, sub_block
from studies.lessons.adjusted import adjusted
from studies.lessons.lesson import SEED

CAMERAS = {"ww": "wide angle, RMK A 15/23", "sww": "super-wide angle, RMK A 8.5/23"}
SECOND_ZEROS_MM = tuple(float(r) for r in range(0, 141, 10))
RADII_MM = np.linspace(0.0, 150.0, 76)


@dataclass(frozen=True, eq=False)
class OneCamera:
    """The images of one camera over Rheidt, and which of them are the middle ones of their strips."""

    camera: str
    block: Block
    middle: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Correlated:
    """What an adjustment with the second zero at r0_mm says.

    z0_a3, z0_a4: mean |R| with the flying height over the middle images; a3_a4: R(a3,a4); std_z0_mm: mean standard
    deviation of their flying heights. radial_um, radial_std_um: the distortion at RADII_MM with its standard deviation.
    """

    r0_mm: float
    z0_a3: float
    z0_a4: float
    a3_a4: float
    std_z0_mm: float
    sigma0: float
    coordinates: Floats
    radial_um: Floats
    radial_std_um: Floats


def flown(camera: str, aux_points: bool) -> OneCamera:
    """The flights of one camera (a key of CAMERAS) in 1980, without or with auxiliary points."""
    block, truth = simulate(presets["rheidt-1980"], SEED)
    return OneCamera(camera, sub_block(block, truth, camera, aux_points), middle_images(truth, camera))


def correlated(of: OneCamera, r0_mm: float) -> Correlated:
    """Adjust with model 3.1 and this second zero. Raises LessonError where that fails."""
    model = ap_models.get("optical", r0_mm=r0_mm)
    a = adjusted(of.block, model)
    radial = ((of.camera, "a3"), (of.camera, "a4"))
    with one_thread():
        covariance = a.covariance(*radial, *((image, "Z0") for image in of.middle))
    r = correlations(covariance)
    terms = 1000.0 * model.basis(RADII_MM, np.zeros_like(RADII_MM))[:, 0, :2]
    return Correlated(
        r0_mm=r0_mm,
        z0_a3=float(np.mean(np.abs(r[0, 2:]))),
        z0_a4=float(np.mean(np.abs(r[1, 2:]))),
        a3_a4=float(r[0, 1]),
        std_z0_mm=1000.0 * float(np.mean(np.sqrt(np.diag(covariance)[2:]))),
        sigma0=a.sigma0,
        coordinates=a.coordinates,
        radial_um=terms @ a.ap[of.camera].values[:2],
        radial_std_um=np.sqrt(np.einsum("ni,ij,nj->n", terms, covariance[:2, :2], terms)),
    )


def curve(of: OneCamera) -> list[Correlated]:
    """The same for all SECOND_ZEROS_MM."""
    return [correlated(of, r0) for r0 in SECOND_ZEROS_MM]


def largest_shift_mm(one: Correlated, other: Correlated) -> float:
    """By how much the adjusted points of two choices of r0 differ at most, mm."""
    return 1000.0 * float(np.abs(one.coordinates - other.coordinates).max())
