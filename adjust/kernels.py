"""The gradient of a block of trials, as plain Python that a compiler takes in (adjust.traced_terms does that).

Trials are the inner, contiguous axis of every array and always LANES wide, so that each innermost loop becomes vector
instructions and a block stays in the second-level cache. Indices are unsigned, for numba then omits its handling of
negative ones, which would keep the loops scalar. What a loop writes lies in one array and what it reads in few, so that
the compiler can prove them apart. No sine, cosine or logarithm is taken here; rotations come in as matrices.
"""

from __future__ import annotations

from typing import Any

import numba
import numpy as np

LANES = 32
"""trials a block"""
ROTATION, STATION, PARAMETERS = 0, 9, 12
"""rows of the context of an image: R by rows, X0, the additional parameters of its set"""
FORCE, TORQUE, VPV, DEPTH, POINT, PULL = 0, 3, 6, 7, 8, 11
"""rows of the sums of an image: see `gradient_block`"""


def distort(x: float, y: float, context: Any, t: int) -> tuple[float, float]:
    """d(x, y) of trial t with the parameters in context; here that of no model, replaced by generated code."""
    return 0.0, 0.0


def pull(x: float, y: float, fx: float, fy: float, sums: Any, t: int) -> None:
    """Add B(x, y)^T (fx, fy) to the parameters' gradient of trial t; replaced by generated code."""


def gradient_block(
    images: Any, starts: Any, point: Any, weight: Any, interior: Any, contexts: Any, first: Any, xy: Any, x: Any, g: Any
) -> Any:
    """Half the gradient of vPv, A^T P v, of the image points of the images `images` (q), which share one AP set.

    starts (m + 1), point (k), weight (k, 2), interior (m, 3) as in adjust.observations.ImagePoints; contexts
    (m, 12 + a, LANES); first: row in x and g of the first point coordinate; xy (k, 2, LANES) measured; x (size, LANES)
    the unknowns. The point part is added to g (size, LANES). Returns sums (m, 11 + a, LANES): force and torque on each
    station (minus the gradient by X0, and by small rotations about the object axes), vPv, the least depth, three rows of
    scratch, the gradient by the parameters.
    """
    sums = np.zeros((starts.size - 1, contexts.shape[1] - 1, 32))
    for i in images:
        context, out = contexts[i], sums[i]
        out[7] = np.inf
        c, px, py = interior[i, 0], interior[i, 1], interior[i, 2]
        for k in range(starts[i], starts[i + np.uint64(1)]):
            row = np.uint64(k)
            at = np.uint64(first) + np.uint64(3) * point[row]
            coordinate, measured = x[at : at + np.uint64(3)], xy[row]
            wx, wy = weight[row, 0], weight[row, 1]
            for t in range(32):
                mx, my = measured[0, t], measured[1, t]
                rx = coordinate[0, t] - context[9, t]
                ry = coordinate[1, t] - context[10, t]
                rz = coordinate[2, t] - context[11, t]
                p1 = context[0, t] * rx + context[3, t] * ry + context[6, t] * rz
                p2 = context[1, t] * rx + context[4, t] * ry + context[7, t] * rz
                p3 = context[2, t] * rx + context[5, t] * ry + context[8, t] * rz
                inverse = 1.0 / p3
                u, w = p1 * inverse, p2 * inverse
                dx, dy = distort(mx, my, context, t)
                vx = px - c * u + dx - mx
                vy = py - c * w + dy - my
                fx, fy = wx * vx, wy * vy
                # A^T P v by p is (-c / p3) (fx, fy, -(fx u + fy w)); R turns it into the object frame
                f1, f2 = -c * inverse * fx, -c * inverse * fy
                f3 = -(f1 * u + f2 * w)
                gx = context[0, t] * f1 + context[1, t] * f2 + context[2, t] * f3
                gy = context[3, t] * f1 + context[4, t] * f2 + context[5, t] * f3
                gz = context[6, t] * f1 + context[7, t] * f2 + context[8, t] * f3
                out[0, t] += gx
                out[1, t] += gy
                out[2, t] += gz
                out[3, t] += ry * gz - rz * gy
                out[4, t] += rz * gx - rx * gz
                out[5, t] += rx * gy - ry * gx
                out[6, t] += fx * vx + fy * vy
                out[7, t] = min(out[7, t], -p3)
                out[8, t], out[9, t], out[10, t] = gx, gy, gz
                pull(mx, my, fx, fy, out, t)
            gradient = g[at : at + np.uint64(3)]
            for t in range(32):
                gradient[0, t] += out[8, t]
                gradient[1, t] += out[9, t]
                gradient[2, t] += out[10, t]
    return sums


@numba.njit(cache=True)
def transpose(image_points: Any, order: Any, lanes: Any) -> None:
    """lanes[k, :, t] = image_points[t, order[k], :]."""
    for k in range(order.size):
        at = np.uint64(order[k])
        for t in range(image_points.shape[0]):
            lanes[k, 0, t] = image_points[t, at, 0]
            lanes[k, 1, t] = image_points[t, at, 1]
