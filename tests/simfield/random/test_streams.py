"""Streams are apart for every name, whatever a short checksum of it says."""

import zlib
from itertools import combinations

import numpy as np
import pytest

from simfield.random import counter_key, fill, name_words, normal_pairs, stream

ALIKE = [("plumless", "buckeroo"), ("codding", "gnu"), ("exhibiters", "schlager")]
"""pairs of words with one CRC-32"""
KEYS = [
    ("heights",),
    ("heights", 1),
    ("heights", "1"),
    ("heights1",),
    ("height", "s1"),
    ("heights", 1, 1),
    ("heights", 11),
]


@pytest.mark.parametrize(("one", "other"), ALIKE)
def test_names_with_one_checksum_have_their_own_numbers(one, other):
    assert zlib.crc32(one.encode()) == zlib.crc32(other.encode())
    assert (stream(1, "omission", one).random(5) != stream(1, "omission", other).random(5)).all()
    assert counter_key(1, one) != counter_key(1, other)
    a, b = name_words([one, other])
    assert (normal_pairs((1, 2), 3, a, np.arange(9)) != normal_pairs((1, 2), 3, b, np.arange(9))).all()


@pytest.mark.parametrize(("one", "other"), list(combinations(KEYS, 2)))
def test_keys_that_look_alike_are_different_streams(one, other):
    assert stream(1, *one).random() != stream(1, *other).random()
    assert stream(1, *one).random() != stream(2, *one).random()


def test_words_that_differ_in_their_upper_half_alone_give_different_numbers_in_both_forms():
    words = np.array([7, 7 + (1 << 32), 7 + (5 << 40)], dtype=np.uint64)
    readable = normal_pairs((1, 2), np.full(3, 4)[:, None], words[:, None], np.arange(16)[None])
    assert len(np.unique(readable[:, :, 0])) == readable[:, :, 0].size
    lanes = np.empty((2, 3, 2, 8))
    fill(lanes, np.zeros((3, 2)), np.ones((3, 2)), np.full(3, 4, dtype=np.uint64), words, 0, np.uint64(1), np.uint64(2))
    compiled = lanes.transpose(1, 0, 3, 2).reshape(3, 16, 2)
    np.testing.assert_array_equal(compiled, readable)


def test_words_of_a_million_names_are_all_different():
    names = [f"{flight}-h{strip}-{image}" for flight in "abcd" for strip in range(50) for image in range(5000)]
    assert len(np.unique(name_words(names))) == len(names)


@pytest.mark.parametrize("key", [(-1, "a"), (1, -1), (1, "a", -2)])
def test_negative_numbers_are_refused(key):
    with pytest.raises(ValueError, match="numbers from 0"):
        stream(*key)
