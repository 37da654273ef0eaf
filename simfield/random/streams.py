"""Named, independent streams of random numbers.

A stream is keyed by the seed and by the names of what is drawn, never by the order of drawing: a concern that is added,
switched off or drawn twice leaves every other number as it was.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable

import numpy as np

from simfield.random.counter_normals import Words


def stream(seed: int, *key: str | int) -> np.random.Generator:
    """The generator of one concern, for example stream(1980, "image-noise", trial, image_id).

    Names and numbers enter together by their SHA-256: no two keys share a stream. Raises ValueError for a negative seed
    or number.
    """
    return np.random.Generator(np.random.PCG64(_sequence(seed, key)))


def _sequence(seed: int, key: tuple[str | int, ...]) -> np.random.SeedSequence:
    if seed < 0 or any(isinstance(k, int) and k < 0 for k in key):
        raise ValueError(f"seed and trial are numbers from 0, found seed {seed} and key {key}")
    digest = hashlib.sha256(json.dumps([k if isinstance(k, str) else int(k) for k in key]).encode()).digest()
    return np.random.SeedSequence(seed, spawn_key=tuple(int(w) for w in np.frombuffer(digest, dtype="<u4")))


def counter_key(seed: int, *key: str | int) -> tuple[int, int]:
    """Two 32-bit words that key the counters of one concern (simfield.random.counter_normals). Raises as `stream`."""
    first, second = _sequence(seed, key).generate_state(2)
    return int(first), int(second)


def name_words(names: Iterable[str]) -> Words:
    """(m) the second counter words of names (m), of 64 bits: a million names have two alike once in 4e7 times.

    They are the first eight bytes of the SHA-256 of a name.
    """
    first = [hashlib.sha256(name.encode()).digest()[:8] for name in names]
    return np.frombuffer(b"".join(first), dtype="<u8").astype(np.uint64)
