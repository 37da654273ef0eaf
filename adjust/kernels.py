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
    images: Any, starts: Any, point: Any, weight: Any, interior: Any, contexts: Any, first: Any, xy: Any, x: Any,
    sums: Any, g: Any,
) -> None:  # fmt: skip
    """Half the gradient of vPv, A^T P v, of the image points of the images `images` (q), which share one AP set.

    starts (m + 1), point (k), weight (k, 2), interior (m, 3) as in adjust.observations.ImagePoints; contexts
    (m, 12 + a, LANES); first: row in x and g of the first point coordinate; xy (k, 2, LANES) measured; x (size, LANES)
    the unknowns. The point part is added to g (size, LANES), the rest is left in sums (m, 11 + a, LANES): the force and
    the torque on each station (minus the gradient by X0, and minus that by small rotations about the object axes), vPv,
    the least depth, three rows of scratch, and the gradient by the parameters.
    """
    out = np.zeros((sums.shape[1], 32))  # freshly made, so that it is known to overlap nothing
    for i in images:
        context = contexts[i]
        out[:] = 0.0
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
        sums[i] = out


@numba.njit(cache=True, error_model="numpy")
def fill_contexts(images: Any, sine: Any, cosine: Any, x: Any, parameters: Any, contexts: Any) -> None:
    """Rotation, station and parameters of the images `images` into contexts (m, 12 + a, LANES).

    sine, cosine (m, 3, LANES) of omega, phi, kappa; x (size, LANES); parameters: the first row of the set in x.
    """
    for i in images:
        context = contexts[i]
        for t in range(LANES):
            so, sp, sk = sine[i, 0, t], sine[i, 1, t], sine[i, 2, t]
            co, cp, ck = cosine[i, 0, t], cosine[i, 1, t], cosine[i, 2, t]
            context[0, t], context[1, t], context[2, t] = cp * ck, -cp * sk, sp
            context[3, t], context[4, t], context[5, t] = co * sk + so * sp * ck, co * ck - so * sp * sk, -so * cp
            context[6, t], context[7, t], context[8, t] = so * sk - co * sp * ck, so * ck + co * sp * sk, co * cp
        for row in range(3):
            context[STATION + row] = x[np.uint64(6) * i + np.uint64(row)]
        for row in range(contexts.shape[1] - PARAMETERS):
            context[PARAMETERS + row] = x[parameters + row]


@numba.njit(cache=True, error_model="numpy")
def collect(
    images: Any, sums: Any, contexts: Any, sine: Any, cosine: Any, parameters: Any, g: Any, vpv: Any, depth: Any
) -> None:
    """Add what `gradient_block` left in sums to g (size, LANES), vpv and depth (LANES).

    The angles turn about the axes e1, R1 e2 and R e3, and a turn about axis a changes vPv / 2 by -a . torque.
    """
    for i in images:
        out, context = sums[i], contexts[i]
        row = np.uint64(6) * i
        station = g[row : row + np.uint64(6)]
        for t in range(LANES):
            tx, ty, tz = out[3, t], out[4, t], out[5, t]
            station[0, t] = -out[0, t]
            station[1, t] = -out[1, t]
            station[2, t] = -out[2, t]
            station[3, t] = -tx
            station[4, t] = -(cosine[i, 0, t] * ty + sine[i, 0, t] * tz)
            station[5, t] = -(context[2, t] * tx + context[5, t] * ty + context[8, t] * tz)
            vpv[t] += out[VPV, t]
            depth[t] = min(depth[t], out[DEPTH, t])
        for j in range(sums.shape[1] - PULL):
            for t in range(LANES):
                g[parameters + j, t] += out[PULL + j, t]


@numba.njit(cache=True, error_model="numpy")
def scale(g: Any, s: Any, scaled: Any) -> None:
    """scaled = s g in single precision; s (size), g and scaled (size, LANES)."""
    for row in range(s.size):
        for t in range(LANES):
            scaled[row, t] = np.float32(s[row] * g[row, t])


@numba.njit(cache=True, error_model="numpy")
def longest(change: Any, length: Any) -> None:
    """length (LANES): the largest absolute value of each column of change; NaN if there is one."""
    length[:] = 0.0
    for row in range(change.shape[0]):
        for t in range(LANES):
            size = abs(change[row, t])
            length[t] = size if not size <= length[t] else length[t]


@numba.njit(cache=True, error_model="numpy")
def advance(change: Any, active: Any, s: Any, start: Any, y: Any, x: Any) -> None:
    """y -= change and x = start + s y for the active trials; all (size, LANES) but active (LANES, 1.0 or 0.0) and s."""
    for row in range(s.size):
        for t in range(LANES):
            y[row, t] -= np.float64(change[row, t]) if active[t] else 0.0
            x[row, t] = start[row, t] + s[row] * y[row, t]


@numba.njit(cache=True)
def transpose(image_points: Any, order: Any, lanes: Any) -> None:
    """lanes[k, :, t] = image_points[t, order[k], :]."""
    for k in range(order.size):
        at = np.uint64(order[k])
        for t in range(image_points.shape[0]):
            lanes[k, 0, t] = image_points[t, at, 0]
            lanes[k, 1, t] = image_points[t, at, 1]


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def first_gradient(
    starts: Any,
    point: Any,
    first: Any,
    set_first: Any,
    v: Any,
    xy: Any,
    jacobian: Any,
    by_point: Any,
    lanes: Any,
    g: Any,
) -> None:
    """The gradient of all trials at one and the same x, to single precision and with the AP terms of one trial.

    Good for a first step, from which exact ones go on. starts (m + 1), point (k); first: row of the first point
    coordinate; set_first (m): that of each image's parameters; v, xy (k, 2): corrections and coordinates of the nominal
    trial; jacobian (k, 2, 6 + a) and by_point (k, 2, 3) there, times the weights, in single precision; lanes
    (k, 2, LANES) measured; g (size, LANES) in single precision, overwritten.
    """
    g[:] = np.float32(0.0)
    width = jacobian.shape[2]
    sums = np.zeros((width, LANES), dtype=np.float32)
    vx, vy = np.zeros(LANES, dtype=np.float32), np.zeros(LANES, dtype=np.float32)
    for i in range(starts.size - 1):
        sums[:] = np.float32(0.0)
        for k in range(starts[np.uint64(i)], starts[np.uint64(i + 1)]):
            row = np.uint64(k)
            ax, ay = v[row, 0] + xy[row, 0], v[row, 1] + xy[row, 1]
            for t in range(LANES):
                vx[t] = np.float32(ax - lanes[row, 0, t])
                vy[t] = np.float32(ay - lanes[row, 1, t])
            for j in range(width):
                jx, jy, total = jacobian[row, 0, j], jacobian[row, 1, j], sums[j]
                for t in range(LANES):
                    total[t] += jx * vx[t] + jy * vy[t]
            for j in range(3):
                jx, jy = by_point[row, 0, j], by_point[row, 1, j]
                total = g[np.uint64(first) + np.uint64(3) * point[row] + np.uint64(j)]
                for t in range(LANES):
                    total[t] += jx * vx[t] + jy * vy[t]
        for j in range(6):
            g[6 * i + j] = sums[j]
        for j in range(6, width):
            for t in range(LANES):
                g[set_first[i] + j - 6, t] += sums[j, t]
