"""Brown's sets: lens and interior orientation of 1971, and the airborne set of 1976, film included.

From general knowledge, no page of the sources at hand. Both contain the interior orientation, which a flat block of
near-vertical images cannot tell from its exterior orientation; the setting `without` leaves parameters out by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.terms import Term, numbered
from simfield.block import Floats

NAMES_1971 = ("dc", "xp", "yp", "K1", "K2", "K3", "P1", "P2", "B1", "B2")
NAMES_1976 = numbered("a", 21)
SHIFT_X, SHIFT_Y = "a shift in x, as X0 of every image gives it", "a shift in y, as Y0 of every image gives it"
SCALE = "a change of scale, as Z0 of every image gives it"
PRINCIPAL_DISTANCE = {"about": "principal distance", "above": 0.0}


@dataclass(frozen=True)
class Brown1971(ApModel):
    """Interior orientation with radial and decentering distortion, affinity and shear about the principal point.

    The terms refer to the principal point as it is estimated, so the set is not linear. dc changes the principal
    distance of the projection, -(c + dc) p_x/p_z; `terms` are the linear form at dc = xp = yp = 0.
    """

    id: ClassVar[str] = "brown1971"
    title: ClassVar[str] = "Brown's close-range set with interior orientation, 10 terms"
    author: ClassVar[str] = "Brown"
    year: ClassVar[int] = 1971
    source: ClassVar[str] = "Brown 1971, Close-range camera calibration, as in Australis and DBAT; from memory"
    certainty: ClassVar[Certainty] = Certainty.MEMORY
    formula: ClassVar[str] = (
        "X = x - x0 - xp, Y = y - y0 - yp, r^2 = X^2 + Y^2, g = K1 r^2 + K2 r^4 + K3 r^6\n"
        "projected with c + dc, which is dc X/c , dc Y/c in linear form\n"
        "dx = xp - [X g + P1 (r^2 + 2X^2) + P2 2XY + B1 X + B2 Y]\n"
        "dy = yp - [Y g + P1 2XY + P2 (r^2 + 2Y^2)]"
    )

    c_mm: float = field(
        default=153.0, metadata={"about": "principal distance of the linear form (drawings, properties)", "above": 0.0}
    )
    without: tuple[str, ...] = field(
        default=(), metadata={"about": "parameters left out, joined by commas", "names": NAMES_1971}
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(name for name in NAMES_1971 if name not in self.without)

    @property
    def linear(self) -> bool:
        return False

    @property
    def principal_distance(self) -> str:
        return "" if "dc" in self.without else "dc"

    @property
    def why_not_estimable(self) -> dict[str, str]:
        why = {"dc": SCALE, "xp": SHIFT_X, "yp": SHIFT_Y}
        return {name: reason for name, reason in why.items() if name not in self.without}

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        distance = (x / self.c_mm, y / self.c_mm)
        shifts = ((1, 0), (0, 1))
        lens = [(-dx, -dy) for dx, dy in _corrections(x, y)]
        named = zip(NAMES_1971, (distance, *shifts, *lens), strict=True)
        return [term for name, term in named if name not in self.without]

    def evaluate(self, x: Floats, y: Floats, values: Floats) -> tuple[Floats, Floats]:
        given = dict(zip(self.parameters, values.tolist(), strict=True))
        all_ten = np.array([given.get(name, 0.0) for name in NAMES_1971])
        xp, yp, lens = all_ten[1], all_ten[2], all_ten[3:]
        x, y = x - xp, y - yp
        by = np.zeros((len(x), 2, 10))
        for j, (dx, dy) in enumerate(_corrections(x, y), start=3):
            by[:, 0, j], by[:, 1, j] = -dx, -dy
        d = by[:, :, 3:] @ lens + [xp, yp]
        by[:, :, 1:3] = np.eye(2) + _gradient(x, y, lens)
        return d, by[:, :, [NAMES_1971.index(name) for name in self.parameters]]


def _corrections(x: Floats, y: Floats) -> list[Term]:
    """The corrections to the measurement of K1, K2, K3, P1, P2, B1, B2 at x, y from the principal point."""
    r2 = x**2 + y**2
    radial = [(x * g, y * g) for g in (r2, r2**2, r2**3)]
    return [*radial, (r2 + 2 * x**2, 2 * x * y), (2 * x * y, r2 + 2 * y**2), (x, 0), (y, 0)]


def _gradient(x: Floats, y: Floats, lens: Floats) -> Floats:
    """(k, 2, 2) the derivatives of the summed corrections by x and y."""
    k1, k2, k3, p1, p2, b1, b2 = lens
    r2 = x**2 + y**2
    g = k1 * r2 + k2 * r2**2 + k3 * r2**3
    slope = 2 * (k1 + 2 * k2 * r2 + 3 * k3 * r2**2)
    xx = g + slope * x**2 + 6 * p1 * x + 2 * p2 * y + b1
    xy = slope * x * y + 2 * p1 * y + 2 * p2 * x
    yy = g + slope * y**2 + 2 * p1 * x + 6 * p2 * y
    return np.stack([np.stack([xx, xy + b2], axis=-1), np.stack([xy, yy], axis=-1)], axis=1)


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

    c_mm: float = field(default=153.0, metadata=PRINCIPAL_DISTANCE)
    without: tuple[str, ...] = field(
        default=(), metadata={"about": "parameters left out, joined by commas", "names": NAMES_1976}
    )

    @property
    def parameters(self) -> tuple[str, ...]:
        return tuple(name for name in NAMES_1976 if name not in self.without)

    @property
    def why_not_estimable(self) -> dict[str, str]:
        why = {"a19": SHIFT_X, "a20": SHIFT_Y, "a21": SCALE}
        return {name: reason for name, reason in why.items() if name not in self.without}

    def terms(self, x: Floats, y: Floats) -> Sequence[Term]:
        c, r2 = self.c_mm, x**2 + y**2
        film_x = [x, y, x * y, y**2, x**2 * y, x * y**2, x**2 * y**2]
        film_y = [x * y, x**2, x**2 * y, x * y**2, x**2 * y**2]
        flatness = [x**2 - y**2, x**2 * y**2, x**4 - y**4]
        terms = [
            *((f, 0) for f in film_x),
            *((0, f) for f in film_y),
            *((x / c * f, y / c * f) for f in flatness),
            *((x * g, y * g) for g in (r2, r2**2, r2**3)),
            (1, 0),
            (0, 1),
            (x / c, y / c),
        ]
        return [term for name, term in zip(NAMES_1976, terms, strict=True) if name not in self.without]
