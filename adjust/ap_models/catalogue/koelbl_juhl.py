"""Koelbl's 9 parameters as modified by Juhl: a reconstruction.

Sure are a1 x + a2 y in dy alone, three radial functions, r^1.85 and the four angular terms. The radial functions
themselves cannot be read in the scan; those here are a guess that fits the visible parts. Results of this set are not
results of Koelbl's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, along_radius, direction_harmonics, numbered
from simfield.block import Floats


@dataclass(frozen=True)
class KoelblJuhl9(ApModel):
    """A reconstruction: the three radial functions are guessed."""

    id: ClassVar[str] = "koelbl-juhl9"
    title: ClassVar[str] = "Koelbl's set modified by Juhl, 9 terms (reconstruction)"
    author: ClassVar[str] = "Koelbl, Juhl"
    year: ClassVar[int] = 1982
    source: ClassVar[str] = (
        "Koelbl, modified by Juhl, as in Ziemann & El-Hakim 1982, p. 120, parameter set k;"
        " a reconstruction: the radial functions of a3, a4, a5 are not readable there"
    )
    certainty: ClassVar[Certainty] = Certainty.RECONSTRUCTION
    formula: ClassVar[str] = (
        "reconstruction; lam = atan2(y, x), r0 = r0_mm\n"
        "g  = a3 (r^3 - r^5/r0^2) + a4 r (sin(pi r/r0) - 1)^2 + a5 sin(4 pi r/r0)"
        " + r^1.85 (a6 cos lam + a7 sin lam + a8 cos 2lam + a9 sin 2lam)\n"
        "dx =               (x/r) g\n"
        "dy = a1 x + a2 y + (y/r) g"
    )

    r0_mm: float = field(
        default=148.0, metadata={"about": "second zero crossing of the radial distortion", "above": 0.0}
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("a", 9)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        r, r0 = np.hypot(x, y), self.r0_mm
        cos, sin = direction_harmonics(x, y, 2)
        radial = [r**3 - r**5 / r0**2, r * (np.sin(np.pi * r / r0) - 1) ** 2, np.sin(4 * np.pi * r / r0)]
        angular = [r**1.85 * f for f in (cos[1], sin[1], cos[2], sin[2])]
        return [(0, x), (0, y), *along_radius(x, y, [*radial, *angular])]
