"""Floating-point operations of a trial, counted by hand; README.md has the table."""

from __future__ import annotations

from dataclasses import dataclass

GEOMETRY = 75
"""an image point without its AP terms: difference 3, rotation 15, perspective 3, residuals 8, weights 2, force 6,
turned back 15, sums of force 3 and torque 12, vPv 4, least depth 1, sums of the object point 3"""
NOISE = 68
"""a pair of normal numbers: logarithm 27, root 2, sine and cosine 33, scaling 6. Not counted: the integer arithmetic of
the counter-based generator, which is more than that"""


@dataclass(frozen=True)
class ApCount:
    """Operations of an AP model at a point: its terms, d = B a, and B^T f."""

    terms: int
    distort: int
    pull: int


BROWN14 = ApCount(terms=39, distort=46, pull=48)
NO_MODEL = ApCount(0, 0, 0)


@dataclass(frozen=True)
class TrialFlops:
    """Operations of one trial, by part. The single precision product counts half: the peak of single is twice that of
    double precision, in which the peak of the machine is measured."""

    gradients: float
    corrections: float
    noise: float

    @classmethod
    def of(cls, image_points: int, unknowns: int, steps: float, ap: ApCount) -> TrialFlops:
        per_point = GEOMETRY + ap.terms + ap.distort + ap.pull
        return cls(steps * per_point * image_points, steps * 2.0 * unknowns**2 / 2.0, float(NOISE * image_points))

    @property
    def total(self) -> float:
        return self.gradients + self.corrections + self.noise
