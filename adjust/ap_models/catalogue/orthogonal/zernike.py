"""Zernike polynomials on the circle through the corners of the format, less the orientation.

dx and dy each have all Z_ij of degree i <= n, a complete polynomial. Where an orientation effect combines several of
them, the combinations orthogonal to it on the circle are kept: affinity and shear of the four linear ones, and four of
the six quadratic ones. Degree 3 spans the same space as Mauelshagen's polynomial of 14 terms.

The rule is that of the Legendre set; to apply it here is this project's own choice, from no publication at hand.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, direction_harmonics
from simfield.block import Floats

COMBINED = ("x11c_y11s", "x11s_y11c", "x22c_y22s", "x22s_y22c", "x20_x22c_y22s", "x22s_y20_y22c")


@dataclass(frozen=True)
class Zernike(ApModel):
    """Orthogonal on the circle; the terms are free of unit, the parameters in mm."""

    id: ClassVar[str] = "zernike"
    title: ClassVar[str] = "Zernike polynomials, (n + 1)(n + 2) - 6 terms"
    author: ClassVar[str] = "this project, after Tang, Fritsch, Cramer"
    year: ClassVar[int] = 2012
    source: ClassVar[str] = "Zernike polynomials put to the rule of the Legendre set of Tang, Fritsch & Cramer 2012"
    certainty: ClassVar[Certainty] = Certainty.MEMORY
    formula: ClassVar[str] = (
        "rho = r / sqrt(bx^2 + by^2), lam = atan2(y, x), ZIJc = R_I^J(rho) cos J lam, ZIJs = R_I^J(rho) sin J lam\n"
        "x11c_y11s (Z11c, -Z11s) + x11s_y11c (Z11s, Z11c) + x22c_y22s (Z22c, -Z22s) + x22s_y22c (Z22s, Z22c)"
        " + x20_x22c_y22s (Z22c - 2 Z20, Z22s) + x22s_y20_y22c (Z22s, -Z22c - 2 Z20)\n"
        "dx: + xIJc ZIJc + xIJs ZIJs for 3 <= I <= n;  dy: + yIJc ZIJc + yIJs ZIJs likewise"
    )

    n: int = field(default=4, metadata={"about": "degree", "range": (2, 9)})
    bx_mm: float = field(default=115.0, metadata={"about": "half format along x", "above": 0.0})
    by_mm: float = field(default=115.0, metadata={"about": "half format along y", "above": 0.0})

    @property
    def parameters(self) -> tuple[str, ...]:
        return (*COMBINED, *(f"{axis}{i}{j}{f}" for axis in "xy" for i, j, f in self._plain()))

    def _plain(self) -> list[tuple[int, int, str]]:
        """Degree, angular order and c, s or nothing of the polynomials that stand alone."""
        pairs = [(i, j) for i in range(3, self.n + 1) for j in range(i % 2, i + 1, 2)]
        return [(i, j, f) for i, j in pairs for f in (("c", "s") if j else ("",))]

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        rho = np.hypot(x, y) / math.hypot(self.bx_mm, self.by_mm)
        cos, sin = direction_harmonics(x, y, self.n)

        def Z(i: int, j: int, f: str = "") -> Floats:
            angular = sin[j] if f == "s" else cos[j]
            return radial_polynomial(i, j, rho) * angular

        z11c, z11s, z20, z22c, z22s = Z(1, 1), Z(1, 1, "s"), Z(2, 0), Z(2, 2), Z(2, 2, "s")
        plain = [Z(i, j, f) for i, j, f in self._plain()]
        return [
            (z11c, -z11s),
            (z11s, z11c),
            (z22c, -z22s),
            (z22s, z22c),
            (z22c - 2 * z20, z22s),
            (z22s, -z22c - 2 * z20),
            *((f, 0) for f in plain),
            *((0, f) for f in plain),
        ]


def radial_polynomial(i: int, j: int, rho: Floats) -> Floats:
    """R_i^j(rho) = sum over s of (-1)^s (i - s)! / [s! ((i + j)/2 - s)! ((i - j)/2 - s)!] rho^(i - 2s)."""
    half = (i - j) // 2
    coefficients = [(-1) ** s * math.comb(i - s, s) * math.comb(i - 2 * s, half - s) for s in range(half + 1)]
    total = np.zeros_like(rho)
    for s, a in enumerate(coefficients):
        total = total + a * rho ** (i - 2 * s)
    return total
