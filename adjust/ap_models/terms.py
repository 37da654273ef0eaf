"""Terms of additional parameters: what sets of several families are made of."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from simfield.block import Floats

Term = tuple[Any, Any]
"""One parameter's (dx, dy): arrays of the shape of x, or a plain 0."""


@cache
def numbered(letter: str, count: int, start: int = 1) -> tuple[str, ...]:
    """Parameter names such as b1 .. b14."""
    return tuple(f"{letter}{i}" for i in range(start, start + count))


def direction_harmonics(x: Floats, y: Floats, most: int) -> tuple[list[Floats], list[Floats]]:
    """cos k lam and sin k lam, k = 0 .. most, with lam = atan2(y, x); at the centre lam = 0.

    By the addition theorem from cos lam = x/r and sin lam = y/r: no angle is taken, and compiled code stays fast.
    """
    r = np.hypot(x, y)
    centre = r == 0.0
    r = r + centre
    cos_lam, sin_lam = x / r + centre, y / r
    cos, sin = [np.ones_like(x)], [np.zeros_like(x)]
    for _ in range(most):
        c, s = cos[-1], sin[-1]
        cos.append(c * cos_lam - s * sin_lam)
        sin.append(s * cos_lam + c * sin_lam)
    return cos, sin


def along_radius(x: Floats, y: Floats, functions: Sequence[Floats]) -> list[Term]:
    """(x/r) q, (y/r) q for each q; 0 at r = 0, which is the limit because every q must vanish there."""
    r = np.hypot(x, y)
    r = r + (r == 0.0)
    return [(x / r * q, y / r * q) for q in functions]
