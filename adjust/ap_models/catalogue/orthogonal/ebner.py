"""Ebner's 12 parameters: the complete biquadratic polynomial beside the orientation.

Orthogonal, also to the six orientation effects, on the nine points {-B, 0, B} x {-B, 0, B}.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, numbered
from simfield.block import Floats


@dataclass(frozen=True)
class Ebner12(ApModel):
    """Orthogonal on the 3 x 3 points of the image base."""

    id: ClassVar[str] = "ebner12"
    title: ClassVar[str] = "Ebner's orthogonal polynomial, 12 terms"
    author: ClassVar[str] = "Ebner"
    year: ClassVar[int] = 1976
    source: ClassVar[str] = "Ebner 1976, as in Ziemann & El-Hakim 1982, p. 120, parameter set b"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = (
        "X = x^2 - 2B^2/3, Y = y^2 - 2B^2/3, B = b_mm\n"
        "dx =  b1 x + b2 y - 2 b3 X + b4 xy + b5 Y + b7 xY + b9 Xy + b11 XY\n"
        "dy = -b1 y + b2 x + b3 xy - 2 b4 Y + b6 X + b8 Xy + b10 xY + b12 XY"
    )

    b_mm: float = field(default=90.0, metadata={"about": "image base", "above": 0.0})

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("b", 12)

    @property
    def orthogonal_on_mm(self) -> tuple[float, ...]:
        return (-self.b_mm, 0.0, self.b_mm)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        X, Y = x**2 - 2 * self.b_mm**2 / 3, y**2 - 2 * self.b_mm**2 / 3
        return [
            (x, -y),
            (y, x),
            (-2 * X, x * y),
            (x * y, -2 * Y),
            (Y, 0),
            (0, X),
            (x * Y, 0),
            (0, X * y),
            (X * y, 0),
            (0, x * Y),
            (X * Y, 0),
            (0, X * Y),
        ]
