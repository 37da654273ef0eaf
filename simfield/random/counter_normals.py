"""Normal numbers by counter: number i of a stream is a function of the key and i alone, in any order, on any machine.

Philox4x32-10 (Salmon et al. 2011, Parallel random numbers: as easy as 1, 2, 3) turns a counter of four 32-bit words
into four random ones, Box & Muller (1958) turns two of these into two independent standard normal numbers. They go to
6.7 standard deviations, where one in 4e10 would lie beyond. Logarithm, sine and cosine are polynomials written out
here, so that no mathematical library can change a bit. This is the readable form in numpy;
`simfield.random.counter_normals_compiled` has the same operations compiled, and gives the same bits.
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
LOG_TERMS = tuple(2.0 / (2 * i + 1) for i in range(8))
"""2 artanh(s) = s (2 + 2/3 s^2 + 2/5 s^4 + ...): with |s| <= 0.172 the next term is below 2e-14"""
SINE_TERMS = (1.0, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800, 1 / 6227020800)
COSINE_TERMS = (1.0, -1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800, 1 / 479001600)
"""Taylor series up to a^13 and a^12; for |a| <= pi/4 the next terms are below 4e-13, the step of a 32-bit angle is 1e-9
"""
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
    """log(whole / 2^32) for whole numbers in 1 .. 2^32."""
    bits = whole.astype(np.float64).view(np.int64)
    exponent = (bits >> 52) - 1023
    mantissa = ((bits & 0xFFFFFFFFFFFFF) | (1023 << 52)).view(np.float64)
    large = mantissa > 1.4142135623730951
    mantissa = np.where(large, 0.5 * mantissa, mantissa)
    exponent = exponent + large
    s = (mantissa - 1.0) / (mantissa + 1.0)
    return np.asarray((exponent - 32).astype(np.float64) * LN2 + s * _polynomial(LOG_TERMS, s * s))


def _sine_and_cosine(whole: Words) -> tuple[Floats, Floats]:
    """Sine and cosine of whole / 2^32 of a full turn."""
    number = whole.astype(np.int64)
    quarter = (number + (1 << 29)) >> 30
    angle = (number - (quarter << 30)).astype(np.float64) * (TWO_PI / 2.0**32)
    square = angle * angle
    sine, cosine = angle * _polynomial(SINE_TERMS, square), _polynomial(COSINE_TERMS, square)
    odd = (quarter & 1) == 1
    sine, cosine = np.where(odd, cosine, sine), np.where(odd, sine, cosine)
    return np.where((quarter & 2) == 2, -sine, sine), np.where(((quarter + 1) & 2) == 2, -cosine, cosine)


def _box_muller(w0: Words, w1: Words) -> Floats:
    """(..., 2) normal numbers of two words."""
    radius = np.sqrt(-2.0 * _logarithm(w0 + np.uint64(1)))
    sine, cosine = _sine_and_cosine(w1)
    return np.stack([radius * cosine, radius * sine], axis=-1)


def _counter(first: Any, second: Any, low: Words) -> tuple[Any, Any, Any, Any]:
    """The four words: `second` of 64 bits fills two of them."""
    second = np.asarray(second, dtype=np.uint64)
    return first, second & np.uint64(WORD), low, second >> np.uint64(32)


def normal_pairs(key: tuple[int, int], first: Any, second: Any, trial: Any) -> Floats:
    """(..., 2) standard normal numbers: a pair for the counter words first and second and the number of the trial.

    All are arrays of one shape or numbers; `second` may have 64 bits (simfield.random.name_words). A counter has two
    pairs; they go to two trials that are eight apart, so that eight neighbouring trials are computed together.
    """
    trial = np.asarray(trial, dtype=np.uint64)
    low = (trial >> np.uint64(4) << np.uint64(3)) | (trial & np.uint64(7))
    w0, w1, w2, w3 = philox(_counter(first, second, low), key)
    later = (trial & np.uint64(8)) > 0
    return _box_muller(np.where(later, w2, w0), np.where(later, w3, w1))


def words(key: tuple[int, int], first: Any, second: Any, trial: Any) -> Words:
    """(...) evenly distributed 32-bit words for the same counters: four neighbouring trials share one."""
    trial = np.asarray(trial, dtype=np.uint64)
    four = np.stack(philox(_counter(first, second, trial >> np.uint64(2)), key))
    return np.asarray(
        np.take_along_axis(four, np.broadcast_to(trial & np.uint64(3), four.shape[1:])[None].astype(np.intp), 0)[0]
    )
