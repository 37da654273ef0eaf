"""El-Hakim & Faig's 11 parameters: affinity, shear and spherical-harmonic functions along the radius.

A reading of a bad scan. That the prefix is x/r (and not x) is certain: with x the terms of a3, a4 are (x^2, xy) and
(xy, y^2), which no flat block can tell from phi and omega.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, along_radius, direction_harmonics, numbered
from simfield.block import Floats


@dataclass(frozen=True)
class ElHakimFaig11(ApModel):
    """Harmonics of the image direction, displaced along the radius."""

    id: ClassVar[str] = "elhakim-faig11"
    title: ClassVar[str] = "El-Hakim and Faig's harmonics, 11 terms"
    author: ClassVar[str] = "El-Hakim, Faig"
    year: ClassVar[int] = 1982
    source: ClassVar[str] = "El-Hakim & Faig, as in Ziemann & El-Hakim 1982, p. 120, parameter set c"
    certainty: ClassVar[Certainty] = Certainty.READING
    formula: ClassVar[str] = (
        "lam = atan2(y, x)\n"
        "q  = a3 r cos lam + a4 r sin lam + a5 r^2 + a6 r^2 cos 2lam + a7 r^2 sin 2lam"
        " + a8 r^3 cos lam + a9 r^3 sin lam + a10 r^3 cos 3lam + a11 r^3 sin 3lam\n"
        "dx =  a1 x + a2 y + (x/r) q\n"
        "dy = -a1 y + a2 x + (y/r) q"
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("a", 11)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        return [(x, -y), (y, x), *along_radius(x, y, harmonics(x, y))]


def harmonics(x: Floats, y: Floats) -> list[Floats]:
    """The functions of a3 .. a11, mm^1 to mm^3."""
    r = np.hypot(x, y)
    cos, sin = direction_harmonics(x, y, 3)
    return [
        r * cos[1],
        r * sin[1],
        r**2,
        r**2 * cos[2],
        r**2 * sin[2],
        r**3 * cos[1],
        r**3 * sin[1],
        r**3 * cos[3],
        r**3 * sin[3],
    ]
