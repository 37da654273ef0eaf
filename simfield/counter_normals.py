"""Normal numbers by counter: number i of a stream is a function of the key and i alone, in any order, on any machine.

Philox4x32-10 (Salmon et al. 2011, Parallel random numbers: as easy as 1, 2, 3) turns a counter of four 32-bit words
into four random ones, Box & Muller (1958) turns these into two independent standard normal numbers. Logarithm, sine and
cosine are polynomials written out here, so that no mathematical library can change a bit. `normal_pairs` is the
readable form in numpy; `simfield.compiled_draws` has the same operations compiled, and gives the same bits.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from simfield.block import Floats

MULTIPLIERS = (0xD2511F53, 0xCD9E8D57)
WEYL = (0x9E3779B9, 0xBB67AE85)
ROUNDS = 10
WORD = 0xFFFFFFFF
LN2 = 0.6931471805599453
LOG_TERMS = tuple(2.0 / (2 * i + 1) for i in range(11))
"""2 artanh(s) = s (2 + 2/3 s^2 + 2/5 s^4 + ...): with |s| <= 0.172 the next term is below 1e-18"""
SINE_TERMS = (1.0, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800, 1 / 6227020800, -1 / 1307674368000)
COSINE_TERMS = (
    1.0,
    -1 / 2,
    1 / 24,
    -1 / 720,
    1 / 40320,
    -1 / 3628800,
    1 / 479001600,
    -1 / 87178291200,
    1 / 20922789888000,
)
"""Taylor series up to a^15 and a^16; for |a| <= pi/4 the next terms are below 1e-16"""
TWO_PI = 6.283185307179586

Words = npt.NDArray[np.uint64]


def philox(counter: tuple[Any, Any, Any, Any], key: tuple[int, int]) -> tuple[Words, Words, Words, Words]:
    """The four 32-bit words of Philox4x32-10 for four counter words (arrays of one shape or numbers) and a key."""
    word, half = np.uint64(WORD), np.uint64(32)
    c0, c1, c2, c3 = (np.asarray(c, dtype=np.uint64) for c in counter)
    k0, k1 = (np.uint64(k) for k in key)
    for _ in range(ROUNDS):
        p0, p1 = c0 * np.uint64(MULTIPLIERS[0]), c2 * np.uint64(MULTIPLIERS[1])
        c0, c1, c2, c3 = (p1 >> half) ^ c1 ^ k0, p1 & word, (p0 >> half) ^ c3 ^ k1, p0 & word
        k0, k1 = (np.uint64((int(k) + w) & WORD) for k, w in zip((k0, k1), WEYL, strict=True))
    return c0, c1, c2, c3


def _polynomial(terms: tuple[float, ...], x: Floats) -> Floats:
    """terms[0] + terms[1] x + ..., by Horner's rule."""
    value = np.full_like(x, terms[-1])
    for term in terms[-2::-1]:
        value = value * x + term
    return value


def _logarithm(whole: Words) -> Floats:
    """log(whole / 2^53) for whole numbers in 1 .. 2^53."""
    bits = whole.astype(np.float64).view(np.int64)
    exponent = (bits >> 52) - 1023
    mantissa = ((bits & 0xFFFFFFFFFFFFF) | (1023 << 52)).view(np.float64)
    large = mantissa > 1.4142135623730951
    mantissa = np.where(large, 0.5 * mantissa, mantissa)
    exponent = exponent + large
    s = (mantissa - 1.0) / (mantissa + 1.0)
    return np.asarray((exponent - 53).astype(np.float64) * LN2 + s * _polynomial(LOG_TERMS, s * s))


def _sine_and_cosine(whole: Words) -> tuple[Floats, Floats]:
    """Sine and cosine of whole / 2^53 of a full turn."""
    number = whole.astype(np.int64)
    quarter = (number + (1 << 50)) >> 51
    angle = (number - (quarter << 51)).astype(np.float64) * (TWO_PI / 2.0**53)
    square = angle * angle
    sine, cosine = angle * _polynomial(SINE_TERMS, square), _polynomial(COSINE_TERMS, square)
    odd = (quarter & 1) == 1
    sine, cosine = np.where(odd, cosine, sine), np.where(odd, sine, cosine)
    return np.where((quarter & 2) == 2, -sine, sine), np.where(((quarter + 1) & 2) == 2, -cosine, cosine)


def normal_pairs(key: tuple[int, int], counter: tuple[Any, Any, Any, Any]) -> Floats:
    """(..., 2) standard normal numbers: a pair for every counter."""
    w0, w1, w2, w3 = philox(counter, key)
    low = np.uint64(26)
    radius = np.sqrt(-2.0 * _logarithm(((w0 >> np.uint64(5)) << low) + (w1 >> np.uint64(6)) + np.uint64(1)))
    sine, cosine = _sine_and_cosine(((w2 >> np.uint64(5)) << low) + (w3 >> np.uint64(6)))
    return np.stack([radius * cosine, radius * sine], axis=-1)
