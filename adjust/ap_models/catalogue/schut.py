"""Schut's 14 parameters: a polynomial with the cubic terms a lens needs.

c1 .. c9 and c12 are certain; c10, c11, c13 and c14 are a reading of a bad scan, supported by the published results.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, numbered
from simfield.block import Floats


@dataclass(frozen=True)
class Schut14(ApModel):
    """Terms in x and in y by turns."""

    id: ClassVar[str] = "schut14"
    title: ClassVar[str] = "Schut's polynomial, 14 terms"
    author: ClassVar[str] = "Schut"
    year: ClassVar[int] = 1982
    source: ClassVar[str] = (
        "Schut, as in Ziemann & El-Hakim 1982, p. 120, parameter set m; c10, c11, c13, c14 are a reading"
    )
    certainty: ClassVar[Certainty] = Certainty.READING
    formula: ClassVar[str] = (
        "dx = c3 xy + c5 y^2 + c7 x^2 y + c9 xy^2 + c11 x^2 y^2 + c13 x^3\n"
        "dy = c1 y + c2 x + c4 x^2 + c6 xy + c8 x^2 y + c10 xy^2 + c12 x^2 y^2 + c14 y^3"
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("c", 14)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        return [
            (0, y),
            (0, x),
            (x * y, 0),
            (0, x**2),
            (y**2, 0),
            (0, x * y),
            (x**2 * y, 0),
            (0, x**2 * y),
            (x * y**2, 0),
            (0, x * y**2),
            (x**2 * y**2, 0),
            (0, x**2 * y**2),
            (x**3, 0),
            (0, y**3),
        ]
