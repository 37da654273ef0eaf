"""Salmenpera and Kilpela's 7 parameters: affinity, shear, radial and decentering distortion.

All terms but one are certain; that the r^6 of b5 is one is a reading of a bad scan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, along_radius, numbered
from simfield.block import Floats


@dataclass(frozen=True)
class SalmenperaKilpela7(ApModel):
    """An optical set whose radial curve vanishes at r0."""

    id: ClassVar[str] = "salmenpera-kilpela7"
    title: ClassVar[str] = "Salmenpera and Kilpela's set, 7 terms"
    author: ClassVar[str] = "Salmenpera, Kilpela"
    year: ClassVar[int] = 1982
    source: ClassVar[str] = (
        "Salmenpera & Kilpela, as in Ziemann & El-Hakim 1982, p. 120, parameter set n; one term a reading"
    )
    certainty: ClassVar[Certainty] = Certainty.READING
    formula: ClassVar[str] = (
        "dx =  b1 x + b2 y + x (1 - r0/r)(b3 r^2 + b4 r^4 + b5 r^6) + b6 2xy + b7 (r^2 + 2x^2), r0 = r0_mm\n"
        "dy = -b1 y + b2 x + y (1 - r0/r)(b3 r^2 + b4 r^4 + b5 r^6) + b6 (r^2 + 2y^2) + b7 2xy"
    )

    r0_mm: float = field(
        default=100.0, metadata={"about": "first zero crossing of the radial distortion", "above": 0.0}
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("b", 7)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        r, r0 = np.hypot(x, y), self.r0_mm
        radial = along_radius(x, y, [(r - r0) * r**2, (r - r0) * r**4, (r - r0) * r**6])
        return [(x, -y), (y, x), *radial, (2 * x * y, r**2 + 2 * y**2), (r**2 + 2 * x**2, 2 * x * y)]
