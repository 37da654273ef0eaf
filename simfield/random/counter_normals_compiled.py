"""`simfield.random.counter_normals` compiled, for blocks of trials whose inner axis are the trials.

Operations and their order are those of the readable form and none are fused, so the bits agree. Compiled code is kept
on disk; the first call on a machine compiles for some seconds.

Readable form: `simfield.random.counter_normals`. Agreement: `tests/simfield/random/test_counter_normals.py`.
"""

from __future__ import annotations

import numba
import numpy as np

from simfield.numerics import WIDTH, inlined, kernel, load
from simfield.random.counter_normals import COSINE_TERMS, LN2, LOG_TERMS, MULTIPLIERS, SINE_TERMS, TWO_PI, WEYL

M0, M1 = np.uint64(MULTIPLIERS[0]), np.uint64(MULTIPLIERS[1])
W0, W1 = np.uint64(WEYL[0]), np.uint64(WEYL[1])
WORD, HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
MANTISSA, ONE = 0xFFFFFFFFFFFFF, 1023 << 52
TURN = TWO_PI / 2.0**32
PERIOD = 16
"""trials that 8 counters serve"""
ZERO = np.uint64(0)


@numba.njit(cache=True, error_model="numpy", inline="always")
def philox(c0, c1, c2, c3, k0, k1):  # type: ignore[no-untyped-def]
    for _ in range(10):
        p0, p1 = c0 * M0, c2 * M1
        c0, c1, c2, c3 = (p1 >> HALF) ^ c1 ^ k0, p1 & WORD, (p0 >> HALF) ^ c3 ^ k1, p0 & WORD
        k0, k1 = (k0 + W0) & WORD, (k1 + W1) & WORD
    return c0, c1, c2, c3


@numba.njit(cache=True, error_model="numpy", inline="always")
def _box_muller(w0, w1):  # type: ignore[no-untyped-def]
    bits = np.float64(np.int64(w0 + np.uint64(1))).view(np.int64)
    exponent = (bits >> 52) - 1023
    mantissa = np.int64((bits & MANTISSA) | ONE).view(np.float64)
    large = mantissa > 1.4142135623730951
    mantissa = 0.5 * mantissa if large else mantissa
    exponent = exponent + 1 if large else exponent
    s = (mantissa - 1.0) / (mantissa + 1.0)
    square = s * s
    value = LOG_TERMS[7]
    for i in range(6, -1, -1):
        value = value * square + LOG_TERMS[i]
    radius = np.sqrt(-2.0 * (np.float64(exponent - 32) * LN2 + s * value))
    number = np.int64(w1)
    quarter = (number + (1 << 29)) >> 30
    angle = np.float64(number - (quarter << 30)) * TURN
    square = angle * angle
    sine, cosine = SINE_TERMS[6], COSINE_TERMS[6]
    for i in range(5, -1, -1):
        sine = sine * square + SINE_TERMS[i]
        cosine = cosine * square + COSINE_TERMS[i]
    sine = angle * sine
    odd = (quarter & 1) == 1
    sine, cosine = (cosine if odd else sine), (sine if odd else cosine)
    sine = -sine if (quarter & 2) == 2 else sine
    cosine = -cosine if ((quarter + 1) & 2) == 2 else cosine
    return radius * cosine, radius * sine


@kernel
def draw(first, second, start, k0, k1, drawn):  # type: ignore[no-untyped-def]
    """Standard normal pairs of the trials from `start` on, a multiple of PERIOD, into drawn (2 trials); see `drawn_of`.

    drawn is flat, for loops over several axes are not made vectors.
    """
    n, low = drawn.size // 4, np.uint64(start) >> np.uint64(1)
    for c in range(n):
        w0, w1, w2, w3 = philox(first, second & WORD, low + np.uint64(c), second >> HALF, k0, k1)
        drawn[c], drawn[n + c] = _box_muller(w0, w1)
        drawn[2 * n + c], drawn[3 * n + c] = _box_muller(w2, w3)


@inlined
def drawn_of(drawn, tile, axis):  # type: ignore[no-untyped-def]
    """The lanes of a tile: first (axis 0) or second (axis 1) numbers of the pairs that `draw` has drawn."""
    return load(drawn[(2 * (tile & 1) + axis) * (drawn.size // 4) + WIDTH * (tile >> 1) :])


@numba.njit(cache=True, error_model="numpy")
def fill(out, base, sigma, first, second, start, k0, k1):  # type: ignore[no-untyped-def]
    """out (tiles, k, 2, 8) = base (k, 2) + sigma (k, 2) times the pairs of the trials from `start` on.

    first, second (k): words of the counter; start: a multiple of PERIOD; an even number of tiles. Each row is drawn in
    one piece, which the compiler turns into vectors, and then laid out.
    """
    counters = 8 * (out.shape[0] // 2)
    drawn = np.empty((4, counters))
    low = np.uint64(start) >> np.uint64(1)
    for row in range(out.shape[1]):
        r = np.uint64(row)
        bx, by, sx, sy = base[r, 0], base[r, 1], sigma[r, 0], sigma[r, 1]
        c0, c1, c3 = first[r], second[r] & WORD, second[r] >> HALF
        for t in range(counters):
            w0, w1, w2, w3 = philox(c0, c1, low + np.uint64(t), c3, k0, k1)
            nx, ny = _box_muller(w0, w1)
            drawn[0, t] = bx + sx * nx
            drawn[1, t] = by + sy * ny
            nx, ny = _box_muller(w2, w3)
            drawn[2, t] = bx + sx * nx
            drawn[3, t] = by + sy * ny
        for tile in range(out.shape[0]):
            half, begin = 2 * (tile % 2), tile // 2 * 8
            for t in range(8):
                out[tile, row, 0, t] = drawn[half, begin + t]
                out[tile, row, 1, t] = drawn[half + 1, begin + t]
