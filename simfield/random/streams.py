"""Named, independent streams of random numbers.

A stream is keyed by the seed and by the names of what is drawn, never by the order of drawing: a concern that is added,
switched off or drawn twice leaves every other number as it was.
"""

from __future__ import annotations

import zlib

import numpy as np


def stream(seed: int, *key: str | int) -> np.random.Generator:
    """The generator of one concern, for example stream(1980, "image-noise", trial, image_id).

    Names enter by their CRC-32. Raises ValueError for a negative seed or number.
    """
    return np.random.Generator(np.random.PCG64(_sequence(seed, key)))


def _sequence(seed: int, key: tuple[str | int, ...]) -> np.random.SeedSequence:
    if seed < 0 or any(isinstance(k, int) and k < 0 for k in key):
        raise ValueError(f"seed and trial are numbers from 0, found seed {seed} and key {key}")
    words = tuple(zlib.crc32(k.encode()) if isinstance(k, str) else k for k in key)
    return np.random.SeedSequence(seed, spawn_key=words)


def counter_key(seed: int, *key: str | int) -> tuple[int, int]:
    """Two 32-bit words that key the counters of one concern (simfield.random.counter_normals). Raises as `stream`."""
    first, second = _sequence(seed, key).generate_state(2)
    return int(first), int(second)
