"""Floating-point operations of a trial, counted by hand; README.md has the table."""

from __future__ import annotations

from dataclasses import dataclass

GEOMETRY = 75
"""an image point without its AP terms: difference 3, rotation 15, perspective 3, residuals 8, weights 2, force 6,
turned back 15, sums of force 3 and torque 12, vPv 4, least depth 1, sums of the object point 3"""
NOISE = 56
"""a pair of normal numbers: logarithm 21, root 2, sine and cosine 27, scaling 6. Not counted: the integer arithmetic of
the counter-based generator, which is more than that"""


@dataclass(frozen=True)
class ApCount:
    """Operations of an AP model at a point: its parameters, its terms, d = B a, and B^T f."""

    parameters: int
    terms: int
    distort: int
    pull: int


BROWN14 = ApCount(parameters=14, terms=39, distort=46, pull=48)


@dataclass(frozen=True)
class TrialFlops:
    """Operations of one trial, by part. Single precision counts half: its peak is twice that of double precision, in
    which the peak of the machine is measured."""

    first: float
    gradients: float
    corrections: float
    noise: float

    @classmethod
    def of(cls, image_points: int, unknowns: int, steps: float, ap: ApCount) -> TrialFlops:
        per_point = GEOMETRY + ap.terms + ap.distort + ap.pull
        first = image_points * (2.0 + 4.0 * (9 + ap.parameters)) / 2.0
        corrections = (steps + 1.0) * 2.0 * unknowns**2 / 2.0
        return cls(first, steps * per_point * image_points, corrections, float(NOISE * image_points))

    @property
    def total(self) -> float:
        return self.first + self.gradients + self.corrections + self.noise
