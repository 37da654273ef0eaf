"""Numbers by counter: known answers, the distribution, and the compiled form bit by bit."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from simfield.random import counter_normals_compiled as compiled_draws
from simfield.random.counter_normals import _logarithm, _sine_and_cosine, normal_pairs, philox

TRUNCATION = 1e-12
"""the polynomials against the library: the terms left out"""
KEY = (20, 1980)


@pytest.mark.parametrize(
    ("counter", "key", "words"),
    [
        ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
        ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
        (
            (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
            (0xA4093822, 0x299F31D0),
            (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
        ),
    ],
)
def test_known_answers_of_random123(counter, key, words):
    assert tuple(int(w) for w in philox(counter, key)) == words


def test_logarithm_sine_and_cosine():
    whole = np.random.default_rng(1).integers(1, 2**32, 20_000).astype(np.uint64)
    whole = np.concatenate([whole, np.array([1, 2, 2**31, 2**32 - 1, 2**32], dtype=np.uint64)])
    share = whole.astype(float) / 2.0**32
    assert np.abs(_logarithm(whole) - np.log(share)).max() < TRUNCATION
    sine, cosine = _sine_and_cosine(whole[:-1])
    assert np.abs(sine - np.sin(2 * np.pi * share[:-1])).max() < TRUNCATION
    assert np.abs(cosine - np.cos(2 * np.pi * share[:-1])).max() < TRUNCATION


def test_the_numbers_are_standard_normal():
    numbers = normal_pairs(KEY, np.arange(50_000), 1, 2)
    n = numbers.size
    assert abs(numbers.mean()) < 4 / math.sqrt(n)
    assert abs(numbers.var() - 1.0) < 4 * math.sqrt(2 / n)
    assert abs(stats.kurtosis(numbers.ravel())) < 4 * math.sqrt(24 / n)
    assert stats.kstest(numbers.ravel(), "norm").pvalue > 1e-3


@pytest.mark.parametrize("word", range(3))
def test_neighbours_in_every_counter_word_are_independent(word):
    counter = [np.zeros(20_000, dtype=np.uint64)] * 3
    counter[word] = np.arange(20_000, dtype=np.uint64)
    numbers = normal_pairs(KEY, *counter)
    limit = 4 / math.sqrt(len(numbers))
    for apart in (1, 8, 16):
        assert abs(np.corrcoef(numbers[:-apart, 0], numbers[apart:, 0])[0, 1]) < limit
        assert abs(np.corrcoef(numbers[:-apart, 0], numbers[apart:, 1])[0, 1]) < limit
        assert abs(np.corrcoef(numbers[:-apart, 0] ** 2, numbers[apart:, 0] ** 2)[0, 1]) < 4 * limit
    assert abs(np.corrcoef(numbers[:, 0], numbers[:, 1])[0, 1]) < limit


def test_no_two_trials_share_a_number():
    numbers = normal_pairs(KEY, 5, 7, np.arange(4096))
    assert len(np.unique(numbers)) == numbers.size


@pytest.mark.parametrize("start", [0, 2**31, 2**32 - 32])
def test_compiled_numbers_have_the_same_bits(start):
    rows = 500
    first, second = np.arange(rows, dtype=np.uint64), np.arange(rows, dtype=np.uint64) * np.uint64(77)
    out = np.empty((4, rows, 2, 8))
    base, sigma = np.zeros((rows, 2)), np.ones((rows, 2))
    compiled_draws.fill(out, base, sigma, first, second, start, np.uint64(KEY[0]), np.uint64(KEY[1]))
    readable = normal_pairs(KEY, first[:, None], second[:, None], start + np.arange(32)[None])
    assert np.array_equal(out.transpose(1, 0, 3, 2).reshape(rows, 32, 2), readable)
