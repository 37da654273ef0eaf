"""One compiled loop over the images: the chain of the simulator, then the reductions of the engine, for a block of
trials. Simulator and engine are written apart and meet here alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from adjust.reductions.compiled import reduce_image
from simfield.block import Floats, Indices
from simfield.chain.compiled import below_share, measure_image
from simfield.expansion import REACH_MM


class Tail(NamedTuple):
    """What lens and air take out of the n points, around places (n, 2) where they come to lie but for errors.

    removed (n, 2) mm there and local (n, 2, 5) around (simfield.expansion); wanted: whether anything is taken out.
    """

    place: Floats
    removed: Floats
    local: Floats
    wanted: bool


class Confusion(NamedTuple):
    """Pairs of points that may be taken for each other, by image: rows first (p) and second (p), a counter word each."""

    ends: Indices
    first: Indices
    second: Indices
    word: Any
    key: Any
    share: Any


@numba.njit(cache=True, error_model="numpy")
def measure_and_reduce(lanes, far, start, points, marks, session, frame, tail, confusion, column):  # type: ignore[no-untyped-def]
    """Image coordinates of the trials from `start` on into lanes (tiles, k, 2, 8); returns how many points are far.

    column (n): where each of the sorted points goes. far (k, T): points beyond the reach of the tail's expansion, which
    are left as they are before it.
    """
    count, beyond = 8 * lanes.shape[0], 0
    drawn, pair = np.empty((4, count // 2)), np.empty((2, count))
    for i in range(len(points.ends) - 1):
        begin, end = points.ends[i], points.ends[i + 1]
        if begin == end:
            continue
        first, last = marks.ends[i], marks.ends[i + 1]
        xy, mark_xy = np.empty((end - begin, 2, count)), np.empty((last - first, 2, count))
        measure_image(i, start, points, marks, session, drawn, pair, xy, mark_xy)
        reduce_image(i, frame, points.time[begin:end], marks.time[first:last], xy, mark_xy)
        if tail.wanted:
            for at in range(end - begin):
                beyond += _take_out(
                    tail.place[begin + at], tail.removed[begin + at], tail.local[begin + at], xy[at], far[begin + at]
                )
        if confusion.share > 0:
            _exchange(i, start, confusion, points, xy, far)
        for at in range(end - begin):
            row = column[begin + at]
            for tile in range(lanes.shape[0]):
                for axis in range(2):
                    for t in range(8):
                        lanes[tile, row, axis, t] = xy[at, axis, 8 * tile + t]
    return beyond


@numba.njit(cache=True, error_model="numpy")
def _take_out(place, removed, local, xy, far):  # type: ignore[no-untyped-def]
    """Take out of xy (2, T) what its expansion says; points that are too far stay, and are counted."""
    a0, a1, a2, a3, a4 = local[0, 0], local[0, 1], local[0, 2], local[0, 3], local[0, 4]
    b0, b1, b2, b3, b4 = local[1, 0], local[1, 1], local[1, 2], local[1, 3], local[1, 4]
    x, y, dx, dy = place[0], place[1], removed[0], removed[1]
    beyond = 0
    for t in range(xy.shape[1]):
        u, v = xy[0, t] - x, xy[1, t] - y
        uu, uv, vv = u * u, u * v, v * v
        out = max(abs(u), abs(v)) > REACH_MM
        keep = 0.0 if out else 1.0
        beyond += out
        far[t] = out
        xy[0, t] -= keep * (dx + (a0 * u + a1 * v + a2 * uu + a3 * uv + a4 * vv))
        xy[1, t] -= keep * (dy + (b0 * u + b1 * v + b2 * uu + b3 * uv + b4 * vv))
    return beyond


@numba.njit(cache=True, error_model="numpy")
def _exchange(i, start, confusion, points, xy, far):  # type: ignore[no-untyped-def]
    """Exchange the coordinates xy (n, 2, T) of the pairs of image i that were taken for each other."""
    hit = np.empty(xy.shape[2], dtype=np.bool_)
    begin, k = points.ends[i], confusion.key
    for p in range(confusion.ends[i], confusion.ends[i + 1]):
        one, other = confusion.first[p], confusion.second[p]
        if below_share(confusion.word[p], points.second[one], start, k[0], k[1], confusion.share, hit):
            for t in range(len(hit)):
                if hit[t]:
                    far[one, t], far[other, t] = far[other, t], far[one, t]
                    for axis in range(2):
                        a, b = xy[one - begin, axis, t], xy[other - begin, axis, t]
                        xy[one - begin, axis, t], xy[other - begin, axis, t] = b, a
