"""The three models of Mauelshagen 1980, sections 3.1 to 3.3, and his polynomial of 14 terms.

The paper prints (r^2 - 2x^2), (r^2 - 2y^2) and, in 3.3, b4 xy. Its own Table 2 is reproduced only with Brown's terms
(r^2 + 2x^2), (r^2 + 2y^2) and b4 x^2 y, which are the default here; as_printed=True keeps the printed form.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, along_radius, numbered
from simfield.block import Floats

SECOND_ZERO = {"about": "second zero crossing of the radial distortion; 0 for plain powers of r", "at_least": 0.0}
AS_PRINTED = {"about": "the decentering signs (and b4) as the paper misprints them"}


@dataclass(frozen=True)
class NoModel(ApModel):
    """No additional parameters."""

    id: ClassVar[str] = "none"
    title: ClassVar[str] = "No additional parameters"
    author: ClassVar[str] = "-"
    year: ClassVar[int] = 0
    source: ClassVar[str] = "the collinearity equations alone"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = "dx = dy = 0"

    @property
    def parameters(self) -> tuple[str, ...]:
        return ()

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        return ()


def radial_terms(x: Floats, y: Floats, r0: float, orders: int) -> list[Term]:
    """(x, y)(r^2i - r0^2i) for i = 1 .. orders."""
    r2, zero2 = x**2 + y**2, r0**2
    radial = [r2**i - zero2**i for i in range(1, orders + 1)]
    return [(x * f, y * f) for f in radial]


def decentering_terms(x: Floats, y: Floats, sign: float = 1.0) -> list[Term]:
    """Brown's decentering terms; sign -1 gives the misprint of 1980."""
    r2 = x**2 + y**2
    return [(r2 + sign * 2 * x**2, 2 * x * y), (2 * x * y, r2 + sign * 2 * y**2)]


@dataclass(frozen=True)
class Optical(ApModel):
    """Radial-symmetric and decentering distortion, Mauelshagen's "optisches Polynom"."""

    id: ClassVar[str] = "optical"
    title: ClassVar[str] = "Optical polynomial"
    author: ClassVar[str] = "Mauelshagen"
    year: ClassVar[int] = 1980
    source: ClassVar[str] = "Mauelshagen 1980, ISP Congress Hamburg, Commission I, section 3.1"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = (
        "dx = x [a3 (r^2 - r0^2) + a4 (r^4 - r0^4)] + a5 (r^2 + 2 x^2) + a6 2xy\n"
        "dy = y [a3 (r^2 - r0^2) + a4 (r^4 - r0^4)] + a5 2xy + a6 (r^2 + 2 y^2)"
    )

    r0_mm: float = field(default=100.0, metadata=SECOND_ZERO)
    as_printed: bool = field(default=False, metadata=AS_PRINTED)

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("a", 4, start=3)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        sign = -1.0 if self.as_printed else 1.0
        return [*radial_terms(x, y, self.r0_mm, 2), *decentering_terms(x, y, sign)]


@dataclass(frozen=True)
class Torlegard(ApModel):
    """The optical polynomial with affinity and shear in y."""

    id: ClassVar[str] = "torlegard"
    title: ClassVar[str] = "Optical polynomial with affinity and shear in y"
    author: ClassVar[str] = "Torlegard"
    year: ClassVar[int] = 1967
    source: ClassVar[str] = "Torlegard 1967, as in Mauelshagen 1980, section 3.2"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = "dx = dx of optical\ndy = a1 x + a2 y + dy of optical"

    r0_mm: float = field(default=100.0, metadata=SECOND_ZERO)
    as_printed: bool = field(default=False, metadata=AS_PRINTED)

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("a", 6)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        return [(0, x), (0, y), *Optical(self.r0_mm, self.as_printed).terms(x, y)]


@dataclass(frozen=True)
class Brown14(ApModel):
    """Brown's 1976 set as reduced to 14 terms by Mauelshagen."""

    id: ClassVar[str] = "brown14"
    title: ClassVar[str] = "Brown's set reduced to 14 terms"
    author: ClassVar[str] = "Brown, Mauelshagen"
    year: ClassVar[int] = 1980
    source: ClassVar[str] = "Brown 1976, as in Mauelshagen 1980, section 3.3"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = (
        "q  = b5 xy + b6 x^3 + b7 x^2 y + b8 x y^2 + b9 y^3\n"
        "dx = b1 x + b2 y + b3 x y^2 + (x/r) q"
        " + x [b10 (r^2 - r0^2) + b11 (r^4 - r0^4) + b12 (r^6 - r0^6)] + b13 (r^2 + 2 x^2) + b14 2xy\n"
        "dy = b4 x^2 y               + (y/r) q"
        " + y [b10 (r^2 - r0^2) + b11 (r^4 - r0^4) + b12 (r^6 - r0^6)] + b13 2xy + b14 (r^2 + 2 y^2)"
    )

    r0_mm: float = field(default=100.0, metadata=SECOND_ZERO)
    as_printed: bool = field(default=False, metadata=AS_PRINTED)
    b4_printed: bool = field(default=False, metadata={"about": "b4 xy alone as printed"})
    sign_printed: bool = field(default=False, metadata={"about": "the decentering signs alone as printed"})

    @property
    def parameters(self) -> tuple[str, ...]:
        return numbered("b", 14)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        sign = -1.0 if self.as_printed or self.sign_printed else 1.0
        b4 = x * y if self.as_printed or self.b4_printed else x**2 * y
        return [
            (x, 0),
            (y, 0),
            (x * y**2, 0),
            (0, b4),
            *along_radius(x, y, [x * y, x**3, x**2 * y, x * y**2, y**3]),
            *radial_terms(x, y, self.r0_mm, 3),
            *decentering_terms(x, y, sign),
        ]


@dataclass(frozen=True)
class Mauelshagen14(ApModel):
    """The complete cubic polynomial, less what the orientation takes up."""

    id: ClassVar[str] = "mauelshagen14"
    title: ClassVar[str] = "Mauelshagen's polynomial, 14 terms"
    author: ClassVar[str] = "Mauelshagen"
    year: ClassVar[int] = 1982
    source: ClassVar[str] = "Ziemann & El-Hakim 1982, p. 120, parameter set l"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = (
        "dx = a1 xy + a2 y^2 + a3 x^3 + a4 x^2 y + a5 xy^2 + a6 y^3\n"
        "dy = b1 x + b2 y + b3 x^2 + b4 xy + b5 x^3 + b6 x^2 y + b7 xy^2 + b8 y^3"
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return (*numbered("a", 6), *numbered("b", 8))

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        cubic = [x**3, x**2 * y, x * y**2, y**3]
        in_x = [x * y, y**2, *cubic]
        in_y = [x, y, x**2, x * y, *cubic]
        return [*((f, 0) for f in in_x), *((0, f) for f in in_y)]
