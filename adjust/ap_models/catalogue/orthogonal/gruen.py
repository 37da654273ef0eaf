"""Gruen's sets: 12 parameters of degree 2 in each coordinate, and 44 of degree 4.

Beside the orientation, the 12 span the same functions as Ebner's, and the 44 all polynomials of degree 4 in x and in y.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, numbered
from simfield.block import Floats


@dataclass(frozen=True)
class Gruen12(ApModel):
    """Ebner's space in plain monomials."""

    id: ClassVar[str] = "gruen12"
    title: ClassVar[str] = "Gruen's polynomial, 12 terms"
    author: ClassVar[str] = "Gruen"
    year: ClassVar[int] = 1982
    source: ClassVar[str] = "Gruen, as in Ziemann & El-Hakim 1982, p. 120, parameter set f"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = (
        "dx = a1 y + a2 xy + a3 xy^2 + a4 x^2 y + a5 y^2 + a6 x^2 y^2\n"
        "dy = b1 y + b2 xy + b3 xy^2 + b4 x^2 y + b5 x^2 + b6 x^2 y^2"
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return (*numbered("a", 6), *numbered("b", 6))

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        in_x = [y, x * y, x * y**2, x**2 * y, y**2, x**2 * y**2]
        in_y = [y, x * y, x * y**2, x**2 * y, x**2, x**2 * y**2]
        return [*((f, 0) for f in in_x), *((0, g) for g in in_y)]


@dataclass(frozen=True)
class Gruen44(ApModel):
    """Orthogonal on the 5 x 5 points that lie half an image base apart."""

    id: ClassVar[str] = "gruen44"
    title: ClassVar[str] = "Gruen's orthogonal polynomial, 44 terms"
    author: ClassVar[str] = "Gruen"
    year: ClassVar[int] = 1978
    source: ClassVar[str] = "Gruen 1978, 44 parameters; orthogonality and rank confirmed by computation"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    formula: ClassVar[str] = (
        "k = x^2 - b^2/2, p = x^2 - 17b^2/20, r = x^2 (x^2 - 31b^2/28) + 9b^4/70, b = b_mm\n"
        "l = y^2 - b^2/2, q = y^2 - 17b^2/20, s = y^2 (y^2 - 31b^2/28) + 9b^4/70\n"
        "dx =  a1 x + a2 y + a3 xy - (10/7) a4 k + a5 l + F\n"
        "dy = -a1 y + a2 x - (10/7) a3 l + a4 xy + a6 k + G\n"
        "F = b1 xp + b2 yk + b3 xl + b4 yq + b5 r + b6 xyp + b7 kl + b8 xyq + b9 s + b10 yr + b11 xlp + b12 ykq"
        " + b13 xs + b14 lr + b15 xypq + b16 ks + b17 yqr + b18 xps + b19 rs\n"
        "G = c1 xp + ... + c19 rs, the same functions"
    )

    b_mm: float = field(default=90.0, metadata={"about": "image base, twice the spacing of the points", "above": 0.0})

    @property
    def parameters(self) -> tuple[str, ...]:
        return (*numbered("a", 6), *numbered("b", 19), *numbered("c", 19))

    @property
    def orthogonal_on_mm(self) -> tuple[float, ...]:
        return (-self.b_mm, -self.b_mm / 2, 0.0, self.b_mm / 2, self.b_mm)

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        k, p, r = _even_functions(x, self.b_mm)
        l, q, s = _even_functions(y, self.b_mm)  # noqa: E741  the letters of the source
        low = [(x, -y), (y, x), (x * y, -10 / 7 * l), (-10 / 7 * k, x * y), (l, 0), (0, k)]
        cubic = [x * p, y * k, x * l, y * q]
        quartic = [r, x * y * p, k * l, x * y * q, s]
        quintic = [y * r, x * l * p, y * k * q, x * s]
        high = [l * r, x * y * p * q, k * s, y * q * r, x * p * s, r * s]
        functions = [*cubic, *quartic, *quintic, *high]
        return [*low, *((f, 0) for f in functions), *((0, g) for g in functions)]


def _even_functions(t: Floats, b: float) -> tuple[Floats, Floats, Floats]:
    """k, p, r of t = x (or l, q, s of t = y)."""
    return t**2 - b**2 / 2, t**2 - 17 * b**2 / 20, t**2 * (t**2 - 31 * b**2 / 28) + 9 * b**4 / 70
