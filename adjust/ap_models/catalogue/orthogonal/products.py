"""Products of orthogonal polynomials in both image coordinates, less the orientation: Legendre and Chebyshev.

dx and dy each have all products P_i(u) P_j(v), i <= m, j <= n, with u = x/bx and v = y/by. Six combinations are
orientation effects and are dropped: (1, 0), (0, 1), (x, y), (y, -x), (x^2, xy), (xy, y^2). Where an effect combines two
products, the combination of the two that is orthogonal to it is kept, under the weight for which the polynomials are
orthogonal: x10_y01, x01_y10, x20_y11 and x11_y02, the first two being affinity and shear.

That Chebyshev products follow the rule of the Legendre set is this project's own choice, from no publication at hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term
from simfield.block import Floats

ORDER_X = {"about": "degree along x", "range": (2, 9)}
ORDER_Y = {"about": "degree along y", "range": (2, 9)}
HALF_X = {"about": "half format along x", "above": 0.0}
HALF_Y = {"about": "half format along y", "above": 0.0}
COMBINED = ("x10_y01", "x01_y10", "x20_y11", "x11_y02")


@dataclass(frozen=True)
class Products(ApModel):
    """What Legendre and Chebyshev products share; the terms are free of unit, the parameters in mm."""

    ratio: ClassVar[float]
    """k in (-k P2(u), P1(u) P1(v)), the combination orthogonal to (x^2, xy), on a square format"""

    formula: ClassVar[str] = (
        "u = x/bx, v = y/by, Pij = Pi(u) Pj(v), K = {ratio}\n"
        "x10_y01 (P10, -bx/by P01) + x01_y10 (bx/by P01, P10)"
        " + x20_y11 (-K by/bx P20, P11) + x11_y02 (P11, -K bx/by P02)\n"
        "dx: + xIJ PIJ for all other I <= m, J <= n;  dy: + yIJ PIJ likewise; without P00"
    )

    m: int = field(default=3, metadata=ORDER_X)
    n: int = field(default=3, metadata=ORDER_Y)
    bx_mm: float = field(default=115.0, metadata=HALF_X)
    by_mm: float = field(default=115.0, metadata=HALF_Y)

    @property
    def parameters(self) -> tuple[str, ...]:
        return (*COMBINED, *(f"x{i}{j}" for i, j in self._plain("x")), *(f"y{i}{j}" for i, j in self._plain("y")))

    def _plain(self, axis: str) -> list[tuple[int, int]]:
        """The products that stand alone in dx or in dy."""
        taken = {(0, 0), (1, 0), (0, 1), (1, 1), (2, 0) if axis == "x" else (0, 2)}
        return [(i, j) for i in range(self.m + 1) for j in range(self.n + 1) if (i, j) not in taken]

    def polynomials(self, t: Floats, degree: int) -> list[Floats]:
        """P0 .. Pdegree at t, by recurrence from P0 = 1 and P1 = t."""
        values = [np.ones_like(t), t]
        for i in range(1, degree):
            values.append(self.next_polynomial(i, t, values[i], values[i - 1]))
        return values

    def next_polynomial(self, i: int, t: Floats, current: Floats, previous: Floats) -> Floats:
        """P(i + 1) at t from Pi and P(i - 1)."""
        raise NotImplementedError

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        along = self.polynomials(x / self.bx_mm, self.m)
        across = self.polynomials(y / self.by_mm, self.n)

        def P(i: int, j: int) -> Floats:
            return along[i] * across[j]

        side = self.bx_mm / self.by_mm
        return [
            (P(1, 0), -side * P(0, 1)),
            (side * P(0, 1), P(1, 0)),
            (-self.ratio / side * P(2, 0), P(1, 1)),
            (P(1, 1), -self.ratio * side * P(0, 2)),
            *((P(i, j), 0) for i, j in self._plain("x")),
            *((0, P(i, j)) for i, j in self._plain("y")),
        ]


@dataclass(frozen=True)
class Legendre(Products):
    """Orthogonal over a densely and evenly covered format; (2, 2) is Ebner's space, (4, 4) that of Gruen's 44."""

    id: ClassVar[str] = "legendre"
    title: ClassVar[str] = "Legendre products, 2 (m + 1)(n + 1) - 6 terms"
    author: ClassVar[str] = "Tang, Fritsch, Cramer"
    year: ClassVar[int] = 2012
    source: ClassVar[str] = "Tang, Fritsch & Cramer 2012; number, span and orthogonality confirmed by computation"
    certainty: ClassVar[Certainty] = Certainty.CERTAIN
    ratio: ClassVar[float] = 5 / 6
    formula: ClassVar[str] = Products.formula.format(ratio="5/6")

    def next_polynomial(self, i: int, t: Floats, current: Floats, previous: Floats) -> Floats:
        return ((2 * i + 1) * t * current - i * previous) / (i + 1)


@dataclass(frozen=True)
class Chebyshev(Products):
    """The same space as Legendre's; orthogonal under the weight that stresses the edges of the format."""

    id: ClassVar[str] = "chebyshev"
    title: ClassVar[str] = "Chebyshev products, 2 (m + 1)(n + 1) - 6 terms"
    author: ClassVar[str] = "this project, after Tang, Fritsch, Cramer"
    year: ClassVar[int] = 2012
    source: ClassVar[str] = "Chebyshev polynomials put to the rule of the Legendre set of Tang, Fritsch & Cramer 2012"
    certainty: ClassVar[Certainty] = Certainty.MEMORY
    ratio: ClassVar[float] = 1.0
    formula: ClassVar[str] = Products.formula.format(ratio="1").replace("P", "T")

    def next_polynomial(self, i: int, t: Floats, current: Floats, previous: Floats) -> Floats:
        return 2 * t * current - previous
