"""The gradient of a block of trials, as plain Python that a compiler takes in (adjust.trials.traced_terms does that).

Trials come in tiles of WIDTH, the innermost, contiguous axis of every array; what a tile needs stays in the
second-level cache. The kernels are written in lanes (simfield.numerics.lanes): every name is the number of all trials
of a tile. No sine, cosine or logarithm is taken in the inner loop; rotations come in as matrices.

Readable form: `adjust.normals.normals.Plain`. Agreement: `tests/adjust/trials/test_traced_terms.py`.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np

import simfield.numerics.lanes_compiled  # noqa: F401  lanes for numba
from simfield.numerics import (
    TOGETHER,
    WIDTH,
    WIDTH_SINGLE,
    align_stack,
    choose,
    equal,
    greater,
    least,
    load,
    narrow,
    same,
    store,
    whole,
    widen,
)

TILES = TOGETHER // WIDTH
STATION, PARAMETERS = 9, 12
"""rows of the context of an image: R by rows, X0, the additional parameters of its set"""
VPV, DEPTH, PULL = 6, 7, 8
"""rows of the sums of an image: see `gradient_tile`"""
QUARTER_HIGH, QUARTER_LOW = 1.5707963109016418, 1.5893254773528196e-08
"""a quarter of a turn in two parts, the first with so few digits that its products with whole numbers are exact"""
SINE_TERMS = tuple((-1.0) ** i / math.factorial(2 * i + 1) for i in range(9))
COSINE_TERMS = tuple((-1.0) ** i / math.factorial(2 * i) for i in range(9))
"""up to a^17 and a^16: for |a| <= pi/4 the next terms are below 1e-17"""


def distort(x: Any, y: Any, context: Any, image: Any) -> tuple[Any, Any]:
    """d(x, y) with the parameters in the context of an image; here that of no model, replaced by generated code."""
    return 0.0, 0.0


def no_pull(zero: Any) -> tuple[Any, ...]:
    """A zero for every parameter; replaced by generated code."""
    return ()


def pull(x: Any, y: Any, fx: Any, fy: Any, pulls: tuple[Any, ...]) -> tuple[Any, ...]:
    """pulls + B(x, y)^T (fx, fy); replaced by generated code."""
    return pulls


def keep_pull(pulls: tuple[Any, ...], sums: Any, image: Any) -> None:
    """Write pulls into the rows of an image from PULL on; replaced by generated code."""


def gradient_tile(
    images: Any, starts: Any, point: Any, weight: Any, interior: Any, contexts: Any, first: Any, xy: Any, x: Any,
    sums: Any, g: Any,
) -> None:  # fmt: skip
    """Half the gradient of vPv, A^T P v, of the image points of the images `images` (q), which share one AP set.

    images and starts (m + 1) are unsigned, for numba then omits its handling of negative indices; point (k), weight
    (k, 2), interior (m, 3) as in adjust.observations.image_points.ImagePoints; contexts (m, 12 + a, WIDTH); first:
    row in x and g of the first point coordinate; xy (k, 2, WIDTH) measured; x (size, WIDTH) the unknowns. The point
    part is added to g (size, WIDTH), the rest is left in sums (m, 8 + a, WIDTH): the force and the torque on each
    station (minus the gradient by X0, and minus that by small rotations about the object axes), vPv, the least depth,
    and the gradient by the parameters.
    """
    align_stack()
    zero = same(0.0)
    for i in images:
        r11, r12, r13 = load(contexts, i, 0), load(contexts, i, 1), load(contexts, i, 2)
        r21, r22, r23 = load(contexts, i, 3), load(contexts, i, 4), load(contexts, i, 5)
        r31, r32, r33 = load(contexts, i, 6), load(contexts, i, 7), load(contexts, i, 8)
        sx, sy, sz = load(contexts, i, 9), load(contexts, i, 10), load(contexts, i, 11)
        c, px, py = interior[i, 0], interior[i, 1], interior[i, 2]
        force_x, force_y, force_z, torque_x, torque_y, torque_z = zero, zero, zero, zero, zero, zero
        vpv, depth, pulls = zero, same(np.inf), no_pull(zero)
        for k in range(starts[i], starts[i + np.uint64(1)]):
            at = first + 3 * point[k]
            rx, ry, rz = load(x, at) - sx, load(x, at + 1) - sy, load(x, at + 2) - sz
            p1 = r11 * rx + r21 * ry + r31 * rz
            p2 = r12 * rx + r22 * ry + r32 * rz
            p3 = r13 * rx + r23 * ry + r33 * rz
            inverse = 1.0 / p3
            u, w = p1 * inverse, p2 * inverse
            mx, my = load(xy, k, 0), load(xy, k, 1)
            dx, dy = distort(mx, my, contexts, i)
            vx = px - c * u + dx - mx
            vy = py - c * w + dy - my
            fx, fy = weight[k, 0] * vx, weight[k, 1] * vy
            # A^T P v by p is (-c / p3) (fx, fy, -(fx u + fy w)); R turns it into the object frame
            f1, f2 = -c * inverse * fx, -c * inverse * fy
            f3 = -(f1 * u + f2 * w)
            gx = r11 * f1 + r12 * f2 + r13 * f3
            gy = r21 * f1 + r22 * f2 + r23 * f3
            gz = r31 * f1 + r32 * f2 + r33 * f3
            force_x, force_y, force_z = force_x + gx, force_y + gy, force_z + gz
            torque_x = torque_x + (ry * gz - rz * gy)
            torque_y = torque_y + (rz * gx - rx * gz)
            torque_z = torque_z + (rx * gy - ry * gx)
            vpv = vpv + (fx * vx + fy * vy)
            depth = least(-p3, depth)
            pulls = pull(mx, my, fx, fy, pulls)
            store(g, load(g, at) + gx, at)
            store(g, load(g, at + 1) + gy, at + 1)
            store(g, load(g, at + 2) + gz, at + 2)
        store(sums, force_x, i, 0)
        store(sums, force_y, i, 1)
        store(sums, force_z, i, 2)
        store(sums, torque_x, i, 3)
        store(sums, torque_y, i, 4)
        store(sums, torque_z, i, 5)
        store(sums, vpv, i, 6)
        store(sums, depth, i, 7)
        keep_pull(pulls, sums, i)


def gradient_block(
    images: Any, starts: Any, point: Any, weight: Any, interior: Any, contexts: Any, first: Any, xy: Any, x: Any,
    sums: Any, g: Any,
) -> None:  # fmt: skip
    """`gradient_tile` for all tiles: contexts, xy, x, sums and g have one more, first axis."""
    align_stack()
    for tile in range(x.shape[0]):
        gradient_tile(
            images, starts, point, weight, interior, contexts[tile], first, xy[tile], x[tile], sums[tile], g[tile]
        )


@numba.njit(cache=True, error_model="numpy", inline="always")
def sine_and_cosine(angle: Any) -> Any:
    """Sine and cosine, rad, by Taylor series about the nearest quarter of a turn; |angle| up to some thousand turns."""
    quarter = whole(angle * (2.0 / math.pi))
    rest = (angle - quarter * QUARTER_HIGH) - quarter * QUARTER_LOW
    square = rest * rest
    s, c = same(SINE_TERMS[-1]), same(COSINE_TERMS[-1])
    for i in range(len(SINE_TERMS) - 2, -1, -1):
        s, c = s * square + SINE_TERMS[i], c * square + COSINE_TERMS[i]
    s = s * rest
    of_turn = quarter - 4.0 * whole((quarter - 1.5) / 4.0)
    even, second_half = equal(whole(of_turn / 2.0) * 2.0 - of_turn, 0.0), greater(of_turn, 1.5)
    sine, cosine = choose(even, s, c), choose(even, c, s)
    sine = choose(second_half, -sine, sine)
    return sine, choose(greater(of_turn * (3.0 - of_turn), 1.0), -cosine, cosine)


@numba.njit(cache=True, error_model="numpy")
def fill_contexts(images: Any, renamed: Any, x: Any, parameters: Any, turns: Any, contexts: Any) -> None:
    """Rotation, station and parameters of the images `images` into contexts (tiles, m, 12 + a, WIDTH).

    renamed (m): images whose angles are by the axes Y, Z, X; x (tiles, size, WIDTH); parameters: the first row of the
    set in x; turns (tiles, m, 2, WIDTH): sine and cosine of omega, which `collect` wants.
    """
    for tile in range(x.shape[0]):
        for i in images:
            context, station = contexts[tile, i], x[tile, 6 * i : 6 * i + 6]
            so, co = sine_and_cosine(load(station, 3))
            sp, cp = sine_and_cosine(load(station, 4))
            sk, ck = sine_and_cosine(load(station, 5))
            store(turns, so, tile, i, 0)
            store(turns, co, tile, i, 1)
            first, second, third = (3, 6, 0) if renamed[i] else (0, 3, 6)
            store(context, cp * ck, first)
            store(context, -cp * sk, first + 1)
            store(context, sp, first + 2)
            store(context, co * sk + so * sp * ck, second)
            store(context, co * ck - so * sp * sk, second + 1)
            store(context, -so * cp, second + 2)
            store(context, so * sk - co * sp * ck, third)
            store(context, so * ck + co * sp * sk, third + 1)
            store(context, co * cp, third + 2)
            for row in range(3):
                store(context, load(station, row), STATION + row)
            for row in range(contexts.shape[2] - PARAMETERS):
                store(context, load(x, tile, parameters + row), PARAMETERS + row)


@numba.njit(cache=True, error_model="numpy")
def collect(
    images: Any, renamed: Any, sums: Any, contexts: Any, turns: Any, parameters: Any, g: Any, vpv: Any, depth: Any
) -> None:
    """Add what `gradient_tile` left in sums to g (tiles, size, WIDTH), vpv and depth (tiles, WIDTH).

    The angles turn about the axes e1, R1 e2 and R e3, of the renamed axes where `renamed` (m) says so, and a turn
    about axis a changes vPv / 2 by -a . torque.
    """
    for tile in range(g.shape[0]):
        for i in images:
            out, context, station = sums[tile, i], contexts[tile, i], g[tile, 6 * i : 6 * i + 6]
            tx, ty, tz = load(out, 3), load(out, 4), load(out, 5)
            for row in range(3):
                store(station, -load(out, row), row)
            store(station, -(load(context, 2) * tx + load(context, 5) * ty + load(context, 8) * tz), 5)
            if renamed[i]:
                tx, ty, tz = ty, tz, tx
            store(station, -tx, 3)
            store(station, -(load(turns, tile, i, 1) * ty + load(turns, tile, i, 0) * tz), 4)
            store(vpv, load(vpv, tile) + load(out, VPV), tile)
            store(depth, least(load(out, DEPTH), load(depth, tile)), tile)
            for row in range(sums.shape[2] - PULL):
                at = parameters + row
                store(g, load(g, tile, at) + load(out, PULL + row), tile, at)


@numba.njit(cache=True, error_model="numpy")
def scale(g: Any, free: Any, s: Any, scaled: Any) -> None:
    """scaled (f, TOGETHER) = s g in single precision of the rows free (f); s (f), g (tiles, size, WIDTH)."""
    for number in range(free.size):
        row = free[number]
        for pair in range(g.shape[0] // 2):
            first, second = load(g, 2 * pair, row), load(g, 2 * pair + 1, row)
            store(scaled[number, WIDTH_SINGLE * pair :], narrow(s[number] * first, s[number] * second))


@numba.njit(cache=True, error_model="numpy")
def longest(change: Any, length: Any) -> None:
    """length (TOGETHER): the largest absolute value of each column of change; NaN if there is one."""
    length[:] = 0.0
    for row in range(change.shape[0]):
        for t in range(TOGETHER):
            size = abs(change[row, t])
            length[t] = size if not size <= length[t] else length[t]


@numba.njit(cache=True, error_model="numpy")
def advance(change: Any, active: Any, free: Any, s: Any, start: Any, y: Any, x: Any) -> None:
    """y -= change and x = start + s y in the rows free (f), for the active trials (tiles, WIDTH; 1.0 or 0.0).

    change, y and s are of the free rows alone: change (f, TOGETHER) in single precision, y (tiles, f, WIDTH), s (f);
    start and x (tiles, size, WIDTH).
    """
    for number in range(free.size):
        row = free[number]
        for pair in range(x.shape[0] // 2):
            halves = widen(load(change[number, WIDTH_SINGLE * pair :]))
            for half in range(2):
                tile = 2 * pair + half
                moved = load(y, tile, number) - choose(load(active, tile), halves[half], 0.0)
                store(y, moved, tile, number)
                store(x, load(start, tile, row) + s[number] * moved, tile, row)


@numba.njit(cache=True, error_model="numpy")
def first_gradient(
    starts: Any, point: Any, first: Any, set_first: Any, v: Any, xy: Any, jacobian: Any, by_point: Any, lanes: Any,
    g: Any,
) -> None:  # fmt: skip
    """The gradient of all trials at one and the same x, to single precision and with the AP terms of one trial.

    Good for a first step, from which exact ones go on. starts (m + 1), point (k); first: row of the first point
    coordinate; set_first (m): that of each image's parameters; v, xy (k, 2): corrections and coordinates of the nominal
    trial; jacobian (k, 2, 6 + a) and by_point (k, 2, 3) there, times the weights, in single precision; lanes
    (tiles, k, 2, WIDTH) measured; g (size, tiles / 2, WIDTH_SINGLE) in single precision, overwritten.
    """
    pairs, width = lanes.shape[0] // 2, jacobian.shape[2]
    sums = np.zeros((width, pairs, WIDTH_SINGLE), dtype=np.float32)
    g[:] = np.float32(0.0)
    for i in range(starts.size - 1):
        sums[:] = np.float32(0.0)
        for k in range(starts[np.uint64(i)], starts[np.uint64(i + 1)]):
            ax, ay, at = v[k, 0] + xy[k, 0], v[k, 1] + xy[k, 1], first + 3 * point[k]
            for pair in range(pairs):
                one, two = lanes[2 * pair, k], lanes[2 * pair + 1, k]
                vx, vy = narrow(ax - load(one, 0), ax - load(two, 0)), narrow(ay - load(one, 1), ay - load(two, 1))
                for j in range(width):
                    store(sums, load(sums, j, pair) + (jacobian[k, 0, j] * vx + jacobian[k, 1, j] * vy), j, pair)
                for j in range(3):
                    pulled = by_point[k, 0, j] * vx + by_point[k, 1, j] * vy
                    store(g, load(g, at + j, pair) + pulled, at + j, pair)
        for pair in range(pairs):
            for j in range(6):
                store(g, load(sums, j, pair), 6 * i + j, pair)
            for j in range(6, width):
                at = set_first[i] + j - 6
                store(g, load(g, at, pair) + load(sums, j, pair), at, pair)
