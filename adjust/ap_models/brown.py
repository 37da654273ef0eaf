"""Brown's airborne set of 1976: film, film flattening, lens and interior orientation in 21 parameters.

From general knowledge, no page of the source at hand. a19, a20, a21 are the interior orientation, which a flat block of
near-vertical images cannot tell from its exterior orientation; the other 18 can be estimated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from adjust.ap_models.model import ApModel, Certainty, Term, numbered
from simfield.block import Floats


@dataclass(frozen=True)
class Brown1976(ApModel):
    """Film deformation, unflatness, radial distortion and interior orientation."""

    id: ClassVar[str] = "brown1976"
    title: ClassVar[str] = "Brown's airborne set, 21 terms"
    author: ClassVar[str] = "Brown"
    year: ClassVar[int] = 1976
    source: ClassVar[str] = "Brown 1976, the bundle adjustment, ISP Congress Helsinki; from memory"
    certainty: ClassVar[Certainty] = Certainty.MEMORY
    formula: ClassVar[str] = (
        "f  = a13 (x^2 - y^2) + a14 x^2 y^2 + a15 (x^4 - y^4), g = a16 r^2 + a17 r^4 + a18 r^6, c = c_mm\n"
        "dx = a1 x + a2 y + a3 xy + a4 y^2 + a5 x^2 y + a6 xy^2 + a7 x^2 y^2 + (x/c) f + x g + a19 + a21 x/c\n"
        "dy = a8 xy + a9 x^2 + a10 x^2 y + a11 xy^2 + a12 x^2 y^2            + (y/c) f + y g + a20 + a21 y/c"
    )

    c_mm: float = field(default=153.0, metadata={"about": "principal distance", "above": 0.0})

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("a", 21)

    @property
    def why_not_estimable(self) -> dict[str, str]:
        return {
            "a19": "a shift in x, as X0 of every image gives it",
            "a20": "a shift in y, as Y0 of every image gives it",
            "a21": "a change of scale, as Z0 of every image gives it",
        }

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        c, r2 = self.c_mm, x**2 + y**2
        film_x = [x, y, x * y, y**2, x**2 * y, x * y**2, x**2 * y**2]
        film_y = [x * y, x**2, x**2 * y, x * y**2, x**2 * y**2]
        flatness = [x**2 - y**2, x**2 * y**2, x**4 - y**4]
        return [
            *((f, 0) for f in film_x),
            *((0, f) for f in film_y),
            *((x / c * f, y / c * f) for f in flatness),
            *((x * g, y * g) for g in (r2, r2**2, r2**3)),
            (1, 0),
            (0, 1),
            (x / c, y / c),
        ]
