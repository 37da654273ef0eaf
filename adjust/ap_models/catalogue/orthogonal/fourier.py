"""Fourier series in both image coordinates, after Tang, Fritsch & Cramer 2012.

From general knowledge, no page of the source at hand; the numbers of parameters (16 of order 1, 48 of order 2) agree.
The format is one period, so the functions are mutually orthogonal on it; to the orientation they are not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term
from simfield.block import Floats

ORDER_X = {"about": "order along x", "range": (1, 9)}
ORDER_Y = {"about": "order along y", "range": (1, 9)}
HALF_X = {"about": "half format along x", "above": 0.0}
HALF_Y = {"about": "half format along y", "above": 0.0}


@dataclass(frozen=True)
class Fourier(ApModel):
    """cos and sin of m u + n v in dx and in dy; order 1 has 16 parameters, order 2 has 48."""

    id: ClassVar[str] = "fourier"
    title: ClassVar[str] = "Fourier series, 4 [m (2n + 1) + n] terms"
    author: ClassVar[str] = "Tang, Fritsch, Cramer"
    year: ClassVar[int] = 2012
    source: ClassVar[str] = "Tang, Fritsch & Cramer 2012; from memory"
    certainty: ClassVar[Certainty] = Certainty.MEMORY
    formula: ClassVar[str] = (
        "u = pi x/bx, v = pi y/by\n"
        "dx = sum of xcI+J cos(I u + J v) + xsI+J sin(I u + J v), dy with ycI+J, ysI+J\n"
        "I = 1 .. m with J = -n .. n, and I = 0 with J = 1 .. n"
    )

    m: int = field(default=1, metadata=ORDER_X)
    n: int = field(default=1, metadata=ORDER_Y)
    bx_mm: float = field(default=115.0, metadata=HALF_X)
    by_mm: float = field(default=115.0, metadata=HALF_Y)

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(f"{axis}{f}{i}{j:+d}" for axis in "xy" for i, j in self.waves for f in "cs")

    @property
    def waves(self) -> list[tuple[int, int]]:
        """The pairs of frequencies, one of each (i, j) and (-i, -j)."""
        first = [(0, j) for j in range(1, self.n + 1)]
        return first + [(i, j) for i in range(1, self.m + 1) for j in range(-self.n, self.n + 1)]

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        u, v = np.pi * x / self.bx_mm, np.pi * y / self.by_mm
        functions = [f(i * u + j * v) for i, j in self.waves for f in (np.cos, np.sin)]
        return [*((f, 0) for f in functions), *((0, f) for f in functions)]
