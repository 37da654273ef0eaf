"""A displacement around given places, to second order: a few products where the formula itself would cost a root.

Trials move a point by hundredths of a millimetre. Over such a way the third order of any lens or film is below 1e-9 mm.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from simfield.block import Floats

REACH_MM = 0.1
"""how far from its place an expansion is used: the third order of a bad lens, 4e-6 / mm^2, makes 7e-10 mm there"""
STEP_MM = 0.05


def second_order(displacement: Callable[[Floats], Floats], xy_mm: Floats) -> Floats:
    """(k, 2, 5): what multiplies u, v, u^2, uv, v^2 in displacement(xy + (u, v)) - displacement(xy), in dx and dy.

    By central differences over STEP_MM at xy (k, 2); errors of a part are below 1e-9 mm within REACH_MM.
    """
    h = STEP_MM
    u, v = np.array([h, 0.0]), np.array([0.0, h])
    here = displacement(xy_mm)
    right, left = displacement(xy_mm + u), displacement(xy_mm - u)
    above, below = displacement(xy_mm + v), displacement(xy_mm - v)
    corners = (displacement(xy_mm + u + v) + displacement(xy_mm - u - v)) - (
        displacement(xy_mm + u - v) + displacement(xy_mm - u + v)
    )
    return np.stack(
        [
            (right - left) / (2.0 * h),
            (above - below) / (2.0 * h),
            (right - 2.0 * here + left) / (2.0 * h * h),
            corners / (4.0 * h * h),
            (above - 2.0 * here + below) / (2.0 * h * h),
        ],
        axis=2,
    )
