"""Jacobsen's 12 parameters of the program BLUH, for the 23 cm format.

From general knowledge, no page of the source at hand. The constants 16384 = 128^2, 0.049087 = pi/64 and
0.098174 = pi/32 belong to r in mm on that format.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, direction_harmonics, numbered
from simfield.block import Floats


@dataclass(frozen=True)
class Jacobsen12(ApModel):
    """Physical terms, angular and radial."""

    id: ClassVar[str] = "jacobsen12"
    title: ClassVar[str] = "Jacobsen's set of program BLUH, 12 terms"
    author: ClassVar[str] = "Jacobsen"
    year: ClassVar[int] = 1980
    source: ClassVar[str] = "Jacobsen, program BLUH, University of Hannover; from memory, the year too"
    certainty: ClassVar[Certainty] = Certainty.MEMORY
    formula: ClassVar[str] = (
        "lam = atan2(y, x), r in mm\n"
        "(dx, dy) = p1 (y, x) + p2 (x, -y) + (x, y) (p3 cos 2lam + p4 sin 2lam + p5 cos lam + p6 sin lam)"
        " + (-y, x) r (p7 cos lam + p8 sin lam)"
        " + (x, y) [p9 (r^2 - 16384) + p10 sin(0.049087 r) + p11 sin(0.098174 r) + p12 sin 4lam]"
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("p", 12)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        r = np.hypot(x, y)
        cos, sin = direction_harmonics(x, y, 4)
        angular = [cos[2], sin[2], cos[1], sin[1]]
        across = [r * cos[1], r * sin[1]]
        radial = [r**2 - 16384, np.sin(0.049087 * r), np.sin(0.098174 * r), sin[4]]
        return [
            (y, x),
            (x, -y),
            *((x * f, y * f) for f in angular),
            *((-y * f, x * f) for f in across),
            *((x * f, y * f) for f in radial),
        ]
