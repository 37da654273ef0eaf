"""One compiled loop over the images: the chain of the simulator, then the reductions of the engine, for a block of
trials. Simulator and engine are written apart and meet here alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from adjust.reductions.compiled import reduce_image, without_lens_and_air
from simfield.block import Floats, Indices
from simfield.chain.compiled import below_share, measure_image
from simfield.expansion import REACH_MM


class Tail(NamedTuple):
    """What lens and air take out of the n points, around places (n, 2) where they come to lie but for errors.

    removed (n, 2) mm there and local (n, 2, 5) around (simfield.expansion); smooth (n): whether that may be used, which
    is not near the centre, where a certificate has no direction; wanted: whether anything is taken out at all.
    """

    place: Floats
    removed: Floats
    local: Floats
    smooth: Any
    wanted: bool


class Confusion(NamedTuple):
    """Pairs of points that may be taken for each other, by image: rows first (p), second (p), a counter word each."""

    ends: Indices
    first: Indices
    second: Indices
    word: Any
    key: Any
    share: Any


@numba.njit(cache=True, error_model="numpy")
def measure_and_reduce(lanes, start, points, marks, session, frame, tail, optics, confusion, column):  # type: ignore[no-untyped-def]
    """Image coordinates of the trials from `start` on into lanes (tiles, k, 2, 8).

    column (n): where each of the sorted points goes. What lies beyond the certificate of its lens becomes NaN.
    """
    count = 8 * lanes.shape[0]
    drawn, pair = np.empty((4, count // 2)), np.empty((2, count))
    for i in range(len(points.ends) - 1):
        begin, end = points.ends[i], points.ends[i + 1]
        if begin == end:
            continue
        first, last = marks.ends[i], marks.ends[i + 1]
        xy, mark_xy = np.empty((end - begin, 2, count)), np.empty((last - first, 2, count))
        measure_image(i, start, points, marks, session, drawn, pair, xy, mark_xy)
        reduce_image(i, frame, points.time[begin:end], marks.time[first:last], xy, mark_xy)
        for at in range(end - begin):
            _put_down(begin + at, at, i, tail, optics, xy, column[begin + at], lanes)
        if confusion.share > 0:
            _exchange(i, start, confusion, points, column, lanes)


@numba.njit(cache=True, error_model="numpy")
def _put_down(n, at, i, tail, optics, xy, row, lanes):  # type: ignore[no-untyped-def]
    """Point n of all, xy[at] (2, T) of image i, into lanes[:, row] without what lens and air have done."""
    local = tail.local
    if not tail.wanted:
        for tile in range(lanes.shape[0]):
            for t in range(8):
                lanes[tile, row, 0, t], lanes[tile, row, 1, t] = xy[at, 0, 8 * tile + t], xy[at, 1, 8 * tile + t]
        return
    a0, a1, a2, a3, a4 = local[n, 0, 0], local[n, 0, 1], local[n, 0, 2], local[n, 0, 3], local[n, 0, 4]
    b0, b1, b2, b3, b4 = local[n, 1, 0], local[n, 1, 1], local[n, 1, 2], local[n, 1, 3], local[n, 1, 4]
    x, y, dx, dy = tail.place[n, 0], tail.place[n, 1], tail.removed[n, 0], tail.removed[n, 1]
    reach = REACH_MM * REACH_MM if tail.smooth[n] else -1.0
    most = 0.0
    for tile in range(lanes.shape[0]):
        for t in range(8):
            p, q = xy[at, 0, 8 * tile + t], xy[at, 1, 8 * tile + t]
            u, v = p - x, q - y
            uu, uv, vv = u * u, u * v, v * v
            most = max(most, uu + vv)
            lanes[tile, row, 0, t] = p - (dx + (a0 * u + a1 * v + a2 * uu + a3 * uv + a4 * vv))
            lanes[tile, row, 1, t] = q - (dy + (b0 * u + b1 * v + b2 * uu + b3 * uv + b4 * vv))
    if most <= reach:
        return
    for tile in range(lanes.shape[0]):
        for t in range(8):
            p, q = xy[at, 0, 8 * tile + t], xy[at, 1, 8 * tile + t]
            if (p - x) ** 2 + (q - y) ** 2 > reach:
                lanes[tile, row, 0, t], lanes[tile, row, 1, t] = without_lens_and_air(i, optics, p, q)


@numba.njit(cache=True, error_model="numpy")
def _exchange(i, start, confusion, points, column, lanes):  # type: ignore[no-untyped-def]
    """Exchange the coordinates of the pairs of image i that were taken for each other."""
    count = 8 * lanes.shape[0]
    hit, word = np.empty(count, dtype=np.bool_), np.empty((4, count // 4), dtype=np.uint64)
    k = confusion.key
    for p in range(confusion.ends[i], confusion.ends[i + 1]):
        one, other = confusion.first[p], confusion.second[p]
        if below_share(confusion.word[p], points.second[one], start, k[0], k[1], confusion.share, word, hit):
            here, there = column[one], column[other]
            for t in range(count):
                if hit[t]:
                    for axis in range(2):
                        a, b = lanes[t // 8, here, axis, t % 8], lanes[t // 8, there, axis, t % 8]
                        lanes[t // 8, here, axis, t % 8], lanes[t // 8, there, axis, t % 8] = b, a
