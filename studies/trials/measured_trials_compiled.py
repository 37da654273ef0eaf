"""One compiled loop over the images: the chain of the simulator, then the reductions of the engine, for some tiles of
trials. Simulator and engine are written apart and meet here alone.

Readable form: `adjust.reductions.reduction.reduce`. Agreement: `tests/agreement/test_measured_trials.py`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from adjust.reductions import oriented, reduced, without_lens_and_air
from simfield.block import Floats, Indices
from simfield.chain import below_share, gross_errors, is_deformed, on_machine, set_marks, smooth_field, take_image
from simfield.disturbances import REACH_MM
from simfield.numerics import WIDTH, align_stack, any_above, inlined, kernel, store
from simfield.random import draw


class Tail(NamedTuple):
    """What lens and air take out of the n points, around places (n, 2) where they come to lie but for errors.

    removed (n, 2) mm there and local (n, 2, 5) around (simfield.disturbances.expansion); smooth (n): whether that may
    be used, which is not near the centre, where a certificate has no direction; wanted: whether anything is taken out
    at all.
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


@kernel
def measure_and_reduce(  # type: ignore[no-untyped-def]
    lanes, start, points, marks, session, frame, tail, optics, confusion, column, room, work, mark_xy
):
    """Image coordinates of the trials from `start` on into lanes (tiles, k, 2, WIDTH), an even number of tiles.

    column (n): where each of the sorted points goes; room, work, mark_xy (tiles, s, 2, WIDTH): to work in. Returns
    whether all points lie within the certificates of their lenses; one that does not becomes NaN.
    """
    align_stack()
    within = True
    deformed, gross = is_deformed(session, room), session.gross_share > 0
    for i in range(len(points.ends) - 1):
        begin, end = points.ends[i], points.ends[i + 1]
        if begin == end:
            continue
        take_image(i, start, session, room)
        set_marks(i, start, marks, session, room, mark_xy)
        oriented(i, frame, marks.time[marks.ends[i] : marks.ends[i + 1]], mark_xy, work)
        for at in range(begin, end, 2):
            smooth_field(points.modes, at, min(at + 1, end - 1), room)
            for n in range(at, min(at + 2, end)):
                first, second = points.first[n], points.second[n]
                some = gross and gross_errors(first, second, start, session, room)
                draw(first, second, start, points.key[0], points.key[1], room.drawn)
                for tile in range(lanes.shape[0]):
                    x, y = on_machine(points, n, n - at, tile, session, deformed, room)
                    x, y = reduced(frame, points.time[n], x, y, tile, work)
                    if tail.wanted:
                        within &= _put_down(n, i, tail, optics, x, y, tile, column[n], lanes, room.exact)
                    else:
                        store(lanes, x, tile, column[n], 0)
                        store(lanes, y, tile, column[n], 1)
                if some:
                    room.gross[:] = 0.0
        if confusion.share > 0:
            _exchange(i, start, confusion, points, column, room, lanes)
    return within


@inlined
def _put_down(n, i, tail, optics, x, y, tile, row, lanes, exact):  # type: ignore[no-untyped-def]
    """Point n of all, lanes (x, y) in image i, into lanes[tile, row] without what lens and air have done.

    Returns whether all trials lie within the certificate; exact (2, WIDTH): to work in.
    """
    local, at_x, at_y = tail.local, tail.place[n, 0], tail.place[n, 1]
    u, v = x - at_x, y - at_y
    uu, uv, vv = u * u, u * v, v * v
    by_x = tail.removed[n, 0] + (local[n, 0, 0] * u + local[n, 0, 1] * v)
    by_y = tail.removed[n, 1] + (local[n, 1, 0] * u + local[n, 1, 1] * v)
    by_x = by_x + (local[n, 0, 2] * uu + local[n, 0, 3] * uv + local[n, 0, 4] * vv)
    by_y = by_y + (local[n, 1, 2] * uu + local[n, 1, 3] * uv + local[n, 1, 4] * vv)
    store(lanes, x - by_x, tile, row, 0)
    store(lanes, y - by_y, tile, row, 1)
    within = True
    if any_above(uu + vv, REACH_MM * REACH_MM if tail.smooth[n] else -1.0):
        store(exact, x, 0)
        store(exact, y, 1)
        within = _put_down_exactly(i, optics, exact, at_x, at_y, tail.smooth[n], tile, row, lanes)
    return within


@kernel
def _put_down_exactly(i, optics, xy, at_x, at_y, smooth, tile, row, lanes):  # type: ignore[no-untyped-def]
    """Those trials of xy (2, WIDTH) that lie beyond the reach of an expansion around (at_x, at_y), or all."""
    reach, within = REACH_MM * REACH_MM if smooth else -1.0, True
    for t in range(WIDTH):
        p, q = xy[0, t], xy[1, t]
        if not (p - at_x) ** 2 + (q - at_y) ** 2 <= reach:
            x, y = without_lens_and_air(i, optics, p, q)
            lanes[tile, row, 0, t], lanes[tile, row, 1, t] = x, y
            within &= x == x
    return within


@kernel
def _exchange(i, start, confusion, points, column, room, lanes):  # type: ignore[no-untyped-def]
    """Exchange the coordinates of the pairs of image i that were taken for each other."""
    k = confusion.key
    for p in range(confusion.ends[i], confusion.ends[i + 1]):
        one, other = confusion.first[p], confusion.second[p]
        share, word = confusion.share, confusion.word[p]
        if below_share(word, points.second[one], start, k[0], k[1], share, room.word, room.hit):
            here, there = column[one], column[other]
            for tile in range(lanes.shape[0]):
                for t in range(WIDTH):
                    if room.hit[tile, t] > 0.0:
                        for axis in range(2):
                            a, b = lanes[tile, here, axis, t], lanes[tile, there, axis, t]
                            lanes[tile, here, axis, t], lanes[tile, there, axis, t] = b, a
