"""The chain for a block of trials of one image, in compiled loops: exposed film onto the comparator.

The readable form is `simfield.chain.measure.Prepared.measure`, whose numbers these are, but for rounding; of two
settings it gives the mean. Trials are the last, contiguous axis; the arithmetic of a trial does not depend on its
neighbours.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numba
import numpy as np

from simfield.block import Floats, Indices
from simfield.chain.measure import KINDS, Prepared, share_of_words
from simfield.compiled_draws import _philox
from simfield.compiled_film import COLUMNS, draw_pairs, film_coefficients, solve_film
from simfield.distortion import FilmTable, measured_from_ideal
from simfield.expansion import second_order
from simfield.moving_film import steps_needed
from simfield.streams import counter_key

ZERO = np.uint64(0)


class Places(NamedTuple):
    """Settings of one kind, points or marks, sorted by image: those of image i from ends[i] to ends[i + 1].

    place (n, 2) on the film with the deformation that all trials share, local (n, 2, 5) around it; modes (n, q) of the
    smooth field; time (n); sigma (n) of the pointing, mm; first (n) and second (n) counter words; keys (3) of pointing,
    setting and gross errors (hit, size), two words each.
    """

    ends: Indices
    place: Floats
    local: Floats
    modes: Floats
    time: Floats
    sigma: Floats
    first: Any
    second: Any
    pointing_key: Any
    setting_key: Any


class Session(NamedTuple):
    """What images and machine have: film table by image, field, placement (rad, mm), machine, errors."""

    table_ends: Indices
    column: Indices
    table_sigma: Floats
    table_key: Any
    table_owner: Any
    steps: int
    field_key: Any
    field_owner: Any
    image_word: Any
    placement_key: Any
    turn_sigma: float
    shift_sigma: float
    matrix: Floats
    drift: Floats
    setting_sigma: float
    gross_share: Any
    gross_size: float
    gross_key: Any
    size_key: Any


def tables(prepared: Prepared, rows: Indices) -> tuple[Places, Places, Session]:
    """Of the image points `rows`, which are sorted by image, of all marks, and of the session."""
    world, chain, k, m = prepared.world, prepared.chain, prepared.count, len(prepared.world.plan)
    on_film = measured_from_ideal(prepared.exposed, prepared.constant_film)
    # the shared deformation is a function of all places at once, so it is expanded for all
    local = second_order(prepared.constant_film, on_film)
    modes = np.zeros((len(on_film), 0)) if prepared.field is None else prepared.field.modes
    sigma = np.concatenate([world.image_noise.sigma, np.full(len(on_film) - k, chain.errors.pointing_um / 1000.0)])
    words, places = prepared.image_words, prepared.place_words
    pointing = (world.image_noise.key, counter_key(world.seed, "mark pointing", KINDS[1]))
    kinds = []
    for kind, of, key in zip(KINDS, (rows, np.arange(k, len(on_film))), pointing, strict=True):
        image = prepared.image[of]
        kinds.append(
            Places(
                np.searchsorted(image, np.arange(m + 1)),
                *(np.ascontiguousarray(a[of]) for a in (on_film, local, modes, prepared.time, sigma)),
                places[of],
                words[image],
                _words(key),
                _words(counter_key(world.seed, "setting", kind)),
            )
        )
    return kinds[0], kinds[1], _session(prepared, on_film, local)


def _session(prepared: Prepared, on_film: Floats, local: Floats) -> Session:
    world, chain, m = prepared.world, prepared.chain, len(prepared.world.plan)
    table, machine, field, errors = (
        FilmTable.of(world.scenario.film, world.plan, world.seed),
        chain.comparator,
        prepared.field,
        chain.errors,
    )
    owner = np.zeros(m, dtype=np.uint64)
    if field is not None:
        owner[prepared.image] = field.owner
    return Session(
        np.searchsorted(table.image, np.arange(m + 1)),
        table.column,
        table.sigma,
        table.key,
        table.owner,
        steps_needed(table, on_film, local),
        _words((0, 0) if field is None else field.key),
        owner,
        prepared.image_words,
        _words(counter_key(world.seed, "placement")),
        float(np.deg2rad(machine.placement_sigma_deg)),
        float(machine.placement_sigma_mm),
        machine.matrix(),
        np.array(machine.drift_um) / 1000.0,
        machine.setting_um / 1000.0 / np.sqrt(machine.settings),
        np.uint64(share_of_words(errors.gross_rate)),
        errors.gross_um / 1000.0,
        _words(counter_key(world.seed, "gross")),
        _words(counter_key(world.seed, "gross size")),
    )


def _words(key: tuple[int, int]) -> Any:
    return np.array(key, dtype=np.uint64)


@numba.njit(cache=True, error_model="numpy")
def measure_image(i, start, points, marks, session, drawn, pair, xy, mark_xy):  # type: ignore[no-untyped-def]
    """xy (n, 2, T) and mark_xy (s, 2, T) mm: the points and marks of image i in the trials from `start` on.

    start and T are multiples of 16; drawn (4, T / 2) and pair (2, T) are scratch.
    """
    lanes = pair.shape[1]
    c = np.empty((2, COLUMNS, lanes))
    film_coefficients(
        session.table_ends[i],
        session.table_ends[i + 1],
        session.column,
        session.table_sigma,
        session.table_key,
        session.table_owner,
        start,
        drawn,
        pair,
        c,
    )
    modes = marks.modes.shape[1]
    field = np.empty((modes, 2, lanes))
    for mode in range(modes):
        k = session.field_key
        draw_pairs(np.uint64(mode), session.field_owner[i], start, k[0], k[1], drawn, field[mode])
    turn = np.empty((3, lanes))
    placed = np.empty((2, lanes))
    k = session.placement_key
    draw_pairs(ZERO, session.image_word[i], start, k[0], k[1], drawn, pair)
    for t in range(lanes):
        angle = session.turn_sigma * pair[0, t]
        turn[0, t], turn[1, t] = np.cos(angle), np.sin(angle)
    draw_pairs(np.uint64(1), session.image_word[i], start, k[0], k[1], drawn, placed)
    for t in range(lanes):
        placed[0, t] *= session.shift_sigma
        placed[1, t] *= session.shift_sigma
    _settings(points.ends[i], points, session, True, start, c, field, turn, placed, drawn, pair, xy)
    _settings(marks.ends[i], marks, session, False, start, c, field, turn, placed, drawn, pair, mark_xy)


@numba.njit(cache=True, error_model="numpy")
def _settings(begin, places, session, can_be_gross, start, c, field, turn, placed, drawn, pair, out):  # type: ignore[no-untyped-def]
    """out (n, 2, T): the rows of `places` from `begin` on, as many as out has."""
    lanes = pair.shape[1]
    shift, u = np.empty((2, lanes)), np.empty((2, lanes))
    m00, m01, m11 = session.matrix[0, 0], session.matrix[0, 1], session.matrix[1, 1]
    for at in range(out.shape[0]):
        row = begin + at
        x, y = places.place[row]
        _smooth(places.modes[row], field, shift)
        if session.table_ends[-1] > 0 or len(places.modes[row]) > 0:
            solve_film(x, y, places.local[row], c, session.steps, shift, u)
        else:
            u[:] = 0.0
        first, second, s = places.first[row], places.second[row], places.sigma[row]
        if s > 0.0:
            k = places.pointing_key
            draw_pairs(first, second, start, k[0], k[1], drawn, pair)
            for t in range(lanes):
                u[0, t] += s * pair[0, t]
                u[1, t] += s * pair[1, t]
        if can_be_gross and session.gross_share > 0:
            _gross(first, second, start, session, drawn, pair, u)
        dx, dy = session.drift * places.time[row]
        for t in range(lanes):
            px, py = x + u[0, t], y + u[1, t]
            qx = turn[0, t] * px - turn[1, t] * py + placed[0, t]
            qy = turn[1, t] * px + turn[0, t] * py + placed[1, t]
            out[at, 0, t] = m00 * qx + m01 * qy + dx
            out[at, 1, t] = m11 * qy + dy
        s = session.setting_sigma
        if s > 0.0:
            k = places.setting_key
            draw_pairs(first, second, start, k[0], k[1], drawn, pair)
            for t in range(lanes):
                out[at, 0, t] += s * pair[0, t]
                out[at, 1, t] += s * pair[1, t]


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def _smooth(modes, field, shift):  # type: ignore[no-untyped-def]
    """shift (2, T) = modes (q) field (q, 2, T)."""
    shift[:] = 0.0
    four = len(modes) // 4 * 4
    for q in range(0, four, 4):
        a, b, c, d = modes[q], modes[q + 1], modes[q + 2], modes[q + 3]
        for axis in range(2):
            for t in range(shift.shape[1]):
                shift[axis, t] += (a * field[q, axis, t] + b * field[q + 1, axis, t]) + (
                    c * field[q + 2, axis, t] + d * field[q + 3, axis, t]
                )
    for q in range(four, len(modes)):
        for axis in range(2):
            for t in range(shift.shape[1]):
                shift[axis, t] += modes[q] * field[q, axis, t]


@numba.njit(cache=True, error_model="numpy")
def below_share(first, second, start, k0, k1, share, hit):  # type: ignore[no-untyped-def]
    """hit (T): whether the word of each trial from `start` on lies below `share`; True if any does."""
    found = False
    low = np.uint64(start) >> np.uint64(2)
    for c in range(len(hit) // 4):
        w0, w1, w2, w3 = _philox(first, second, low + np.uint64(c), ZERO, k0, k1)
        hit[4 * c], hit[4 * c + 1] = w0 < share, w1 < share
        hit[4 * c + 2], hit[4 * c + 3] = w2 < share, w3 < share
        found |= (w0 < share) or (w1 < share) or (w2 < share) or (w3 < share)
    return found


@numba.njit(cache=True, error_model="numpy")
def _gross(first, second, start, session, drawn, pair, u):  # type: ignore[no-untyped-def]
    """Add gross errors to u (2, T)."""
    hit = np.empty(u.shape[1], dtype=np.bool_)
    k = session.gross_key
    if below_share(first, second, start, k[0], k[1], session.gross_share, hit):
        k = session.size_key
        draw_pairs(first, second, start, k[0], k[1], drawn, pair)
        for t in range(u.shape[1]):
            if hit[t]:
                u[0, t] += session.gross_size * pair[0, t]
                u[1, t] += session.gross_size * pair[1, t]
