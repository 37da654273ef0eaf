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
from simfield.moving_film import refuse_steep
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
        place, around, smooth, time, own_sigma = (
            np.ascontiguousarray(a[of]) for a in (on_film, local, modes, prepared.time, sigma)
        )
        ends, setting_key = np.searchsorted(image, np.arange(m + 1)), _words(counter_key(world.seed, "setting", kind))
        kinds.append(
            Places(ends, place, around, smooth, time, own_sigma, places[of], words[image], _words(key), setting_key)
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
    refuse_steep(table, on_film, local)
    owner = np.zeros(m, dtype=np.uint64)
    if field is not None:
        owner[prepared.image] = field.owner
    return Session(
        np.searchsorted(table.image, np.arange(m + 1)),
        table.column,
        table.sigma,
        table.key,
        table.owner,
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
    here, there = np.zeros(2 * lanes), np.zeros(2 * lanes)
    shift_here, shift_there = here.reshape(2, lanes), there.reshape(2, lanes)
    u, set_, smooth = np.zeros((2, lanes)), np.zeros((2, lanes)), field.reshape(len(field), 2 * lanes)
    hit, word = np.empty(lanes, dtype=np.bool_), np.empty((4, lanes // 4), dtype=np.uint64)
    deformed = session.table_ends[-1] > 0 or len(field) > 0
    gross = can_be_gross and session.gross_share > 0
    m00, m01, m11 = session.matrix[0, 0], session.matrix[0, 1], session.matrix[1, 1]
    p0, p1, s0, s1 = places.pointing_key[0], places.pointing_key[1], places.setting_key[0], places.setting_key[1]
    by_setting = session.setting_sigma
    for at in range(out.shape[0]):
        row = begin + at
        x, y, by_pointing = places.place[row, 0], places.place[row, 1], places.sigma[row]
        first, second = places.first[row], places.second[row]
        if deformed:
            if at % 2 == 0:
                _smooth(places.modes, row, min(row + 1, begin + len(out) - 1), smooth, here, there)
            solve_film(x, y, places.local, row, c, shift_here if at % 2 == 0 else shift_there, u)
        if gross:
            _gross(first, second, start, session, drawn, pair, word, hit, u)
        if by_pointing > 0.0:
            draw_pairs(first, second, start, p0, p1, drawn, pair)
        if by_setting > 0.0:
            draw_pairs(first, second, start, s0, s1, drawn, set_)
        dx, dy = session.drift[0] * places.time[row], session.drift[1] * places.time[row]
        for t in range(lanes):
            px, py = x + (u[0, t] + by_pointing * pair[0, t]), y + (u[1, t] + by_pointing * pair[1, t])
            qx = turn[0, t] * px - turn[1, t] * py + placed[0, t]
            qy = turn[1, t] * px + turn[0, t] * py + placed[1, t]
            out[at, 0, t] = m00 * qx + m01 * qy + dx + by_setting * set_[0, t]
            out[at, 1, t] = m11 * qy + dy + by_setting * set_[1, t]
        if gross and not deformed:
            u[:] = 0.0


@numba.njit(cache=True, error_model="numpy", fastmath={"contract"})
def _smooth(modes, one, two, field, first, second):  # type: ignore[no-untyped-def]
    """first and second (2 T) = modes[one] and modes[two] (q) times field (q, 2 T), q a multiple of MODES_TOGETHER."""
    for t in range(len(first)):
        first[t], second[t] = 0.0, 0.0
    for q in range(0, len(field), 8):
        a, b, c, d = modes[one, q], modes[one, q + 1], modes[one, q + 2], modes[one, q + 3]
        e, f, g, h = modes[one, q + 4], modes[one, q + 5], modes[one, q + 6], modes[one, q + 7]
        i, j, k, l = modes[two, q], modes[two, q + 1], modes[two, q + 2], modes[two, q + 3]  # noqa: E741
        m, n, o, p = modes[two, q + 4], modes[two, q + 5], modes[two, q + 6], modes[two, q + 7]
        for t in range(len(first)):
            z0, z1, z2, z3 = field[q, t], field[q + 1, t], field[q + 2, t], field[q + 3, t]
            z4, z5, z6, z7 = field[q + 4, t], field[q + 5, t], field[q + 6, t], field[q + 7, t]
            first[t] += ((a * z0 + b * z1) + (c * z2 + d * z3)) + ((e * z4 + f * z5) + (g * z6 + h * z7))
            second[t] += ((i * z0 + j * z1) + (k * z2 + l * z3)) + ((m * z4 + n * z5) + (o * z6 + p * z7))


@numba.njit(cache=True, error_model="numpy")
def below_share(first, second, start, k0, k1, share, word, hit):  # type: ignore[no-untyped-def]
    """hit (T): whether the word of each trial from `start` on lies below `share`; True if any does.

    word (4, T / 4) is scratch.
    """
    low, least = np.uint64(start) >> np.uint64(2), share
    for c in range(word.shape[1]):
        w0, w1, w2, w3 = _philox(first, second, low + np.uint64(c), ZERO, k0, k1)
        word[0, c], word[1, c], word[2, c], word[3, c] = w0, w1, w2, w3
    for j in range(4):
        for c in range(word.shape[1]):
            least = min(least, word[j, c])
    if least >= share:
        return False
    for c in range(word.shape[1]):
        for j in range(4):
            hit[4 * c + j] = word[j, c] < share
    return True


@numba.njit(cache=True, error_model="numpy")
def _gross(first, second, start, session, drawn, pair, word, hit, u):  # type: ignore[no-untyped-def]
    """Add gross errors to u (2, T); word (4, T / 4) and hit (T) are scratch."""
    lanes = u.shape[1]
    k = session.gross_key
    if below_share(first, second, start, k[0], k[1], session.gross_share, word, hit):
        k = session.size_key
        draw_pairs(first, second, start, k[0], k[1], drawn, pair)
        for t in range(lanes):
            if hit[t]:
                u[0, t] += session.gross_size * pair[0, t]
                u[1, t] += session.gross_size * pair[1, t]
