"""A second, scalar form of the collinearity equations: an independent check of the product's projection.

Typed from the formulas without looking at the product's implementation, with the math module only:
R = R1(omega) R2(phi) R3(kappa) turns camera axes into object axes, p = R^T (X - X0), x = x0 - c p_x / p_z,
y = y0 - c p_y / p_z. Angles in radians. R1, R2, R3 are the right-handed rotations about the x, y and z axis:
R1 = [[1, 0, 0], [0, cos, -sin], [0, sin, cos]], R2 = [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]],
R3 = [[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]].
"""

from __future__ import annotations

import math


def project(
    X: float,
    Y: float,
    Z: float,
    X0: float,
    Y0: float,
    Z0: float,
    omega: float,
    phi: float,
    kappa: float,
    c: float,
    x0: float,
    y0: float,
) -> tuple[float, float]:
    """Image coordinates of the object point X, Y, Z, one elementary rotation after the other.

    p = R3^T R2^T R1^T (X - X0): the difference is turned back by omega, then phi, then kappa; no matrix is formed.
    """
    ax, ay, az = X - X0, Y - Y0, Z - Z0
    # back by omega about the first axis
    bx = ax
    by = math.cos(omega) * ay + math.sin(omega) * az
    bz = -math.sin(omega) * ay + math.cos(omega) * az
    # back by phi about the second axis
    cx = math.cos(phi) * bx - math.sin(phi) * bz
    cy = by
    cz = math.sin(phi) * bx + math.cos(phi) * bz
    # back by kappa about the third axis
    px = math.cos(kappa) * cx + math.sin(kappa) * cy
    py = -math.sin(kappa) * cx + math.cos(kappa) * cy
    pz = cz
    return x0 - c * px / pz, y0 - c * py / pz
