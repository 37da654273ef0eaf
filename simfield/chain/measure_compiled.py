"""The chain for some tiles of trials, in lanes: from the exposed film onto the comparator, image by image.

The readable form is `simfield.chain.measure.PreparedChain.measure`, whose numbers these are, but for rounding; of two
settings it gives the mean. The arithmetic of a trial does not depend on its neighbours.

Readable form: `simfield.chain.measure.PreparedChain`. Agreement: `tests/agreement/test_measured_trials.py`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from simfield.block import Floats
from simfield.disturbances import COLUMNS, film_coefficients, solve_film
from simfield.numerics import WIDTH, Arena, align_stack, inlined, kernel, load, same, store
from simfield.random import HALF, WORD, ZERO, draw, drawn_of, philox


class Room(NamedTuple):
    """Where an image is worked on, for an even number of tiles.

    drawn (2 T), T trials: numbers as `simfield.random.counter_normals_compiled.draw` leaves them; film (tiles, 2,
    COLUMNS, WIDTH) coefficients; field (q, 2 T): numbers of the smooth field, by mode; smooth (2, tiles, 2, WIDTH)
    mm: the field at two places; placed (tiles, 4, WIDTH): cosine and sine of the film's turn, its shift, mm; gross
    (tiles, 2, WIDTH) mm: gross errors of a point; word (4, 2 tiles) and hit (tiles, WIDTH): who has one; exact (2,
    WIDTH) mm: for others.
    """

    drawn: Floats
    film: Floats
    field: Floats
    smooth: Floats
    placed: Floats
    gross: Floats
    word: Any
    hit: Floats
    exact: Floats

    @classmethod
    def of(cls, tiles: int, modes: int, arena: Arena) -> Room:
        """For so many tiles, and so many modes of the smooth field."""
        return cls(
            arena.zeros(2 * tiles * WIDTH),
            arena.zeros(tiles, 2, COLUMNS, WIDTH),
            arena.zeros(modes, 2 * tiles * WIDTH),
            arena.zeros(2, tiles, 2, WIDTH),
            arena.zeros(tiles, 4, WIDTH),
            arena.zeros(tiles, 2, WIDTH),
            np.zeros((4, 2 * tiles), dtype=np.uint64),
            arena.zeros(tiles, WIDTH),
            arena.zeros(2, WIDTH),
        )


@kernel
def take_image(i, start, session, room):  # type: ignore[no-untyped-def]
    """Draw film, smooth field and placement of image i in the trials from `start` on, a multiple of 16."""
    align_stack()
    first, last, s = session.table_ends[i], session.table_ends[i + 1], session
    film_coefficients(
        first, last, s.column, s.table_sigma, s.table_key, s.table_owner, start, room.drawn, room.film
    )  # fmt: skip
    k, owner = session.field_key, session.field_owner[i]
    for mode in range(room.field.shape[0]):
        draw(np.uint64(mode), owner, start, k[0], k[1], room.field[mode])
    k, word = session.placement_key, session.image_word[i]
    draw(ZERO, word, start, k[0], k[1], room.drawn)
    for tile in range(room.placed.shape[0]):
        store(room.placed, drawn_of(room.drawn, tile, 0), tile, 2)
        for t in range(WIDTH):
            angle = session.turn_sigma * room.placed[tile, 2, t]
            room.placed[tile, 0, t], room.placed[tile, 1, t] = np.cos(angle), np.sin(angle)
    draw(np.uint64(1), word, start, k[0], k[1], room.drawn)
    for tile in range(room.placed.shape[0]):
        for axis in range(2):
            store(room.placed, session.shift_sigma * drawn_of(room.drawn, tile, axis), tile, 2 + axis)


@kernel
def smooth_field(modes, one, two, room):  # type: ignore[no-untyped-def]
    """The smooth field at the places `one` and `two`, rows of modes (n, q)."""
    align_stack()
    field, smooth, zero = room.field, room.smooth, same(0.0)
    quarter = field.shape[1] // 4
    for pair in range(smooth.shape[1] // 2):
        even, odd = WIDTH * pair, 2 * quarter + WIDTH * pair
        x0, y0, x1, y1, u0, v0, u1, v1 = zero, zero, zero, zero, zero, zero, zero, zero
        for q in range(field.shape[0]):
            a, b = modes[one, q], modes[two, q]
            even_x, even_y = load(field[q, even:]), load(field[q, even + quarter :])
            odd_x, odd_y = load(field[q, odd:]), load(field[q, odd + quarter :])
            x0, y0, x1, y1 = x0 + a * even_x, y0 + a * even_y, x1 + a * odd_x, y1 + a * odd_y
            u0, v0, u1, v1 = u0 + b * even_x, v0 + b * even_y, u1 + b * odd_x, v1 + b * odd_y
        store(smooth, x0, 0, 2 * pair, 0)
        store(smooth, y0, 0, 2 * pair, 1)
        store(smooth, x1, 0, 2 * pair + 1, 0)
        store(smooth, y1, 0, 2 * pair + 1, 1)
        store(smooth, u0, 1, 2 * pair, 0)
        store(smooth, v0, 1, 2 * pair, 1)
        store(smooth, u1, 1, 2 * pair + 1, 0)
        store(smooth, v1, 1, 2 * pair + 1, 1)


@inlined
def on_machine(places, row, half, tile, session, deformed, room):  # type: ignore[no-untyped-def]
    """Machine coordinates, two lanes in mm, of a place whose numbers are drawn and whose smooth field is in `half`.

    deformed: whether there is any film that changes from trial to trial.
    """
    x, y, sigma = places.place[row, 0], places.place[row, 1], places.sigma[row]
    u, v = load(room.smooth, half, tile, 0), load(room.smooth, half, tile, 1)
    if deformed:
        u, v = solve_film(x, y, places.local, row, room.film, tile, u, v)
    px = x + (u + load(room.gross, tile, 0) + sigma * drawn_of(room.drawn, tile, 0))
    py = y + (v + load(room.gross, tile, 1) + sigma * drawn_of(room.drawn, tile, 1))
    cosine, sine = load(room.placed, tile, 0), load(room.placed, tile, 1)
    qx = cosine * px - sine * py + load(room.placed, tile, 2)
    qy = sine * px + cosine * py + load(room.placed, tile, 3)
    matrix, time = session.matrix, places.time[row]
    return (
        matrix[0, 0] * qx + (matrix[0, 1] * qy + session.drift[0] * time),
        matrix[1, 1] * qy + session.drift[1] * time,
    )


@kernel
def set_marks(i, start, marks, session, room, xy):  # type: ignore[no-untyped-def]
    """xy (tiles, s, 2, WIDTH) mm: machine coordinates of the settings of marks in image i, which is taken."""
    align_stack()
    begin, end = marks.ends[i], marks.ends[i + 1]
    deformed = is_deformed(session, room)
    for at in range(begin, end, 2):
        smooth_field(marks.modes, at, min(at + 1, end - 1), room)
        for row in range(at, min(at + 2, end)):
            draw(marks.first[row], marks.second[row], start, marks.key[0], marks.key[1], room.drawn)
            for tile in range(xy.shape[0]):
                x, y = on_machine(marks, row, row - at, tile, session, deformed, room)
                store(xy, x, tile, row - begin, 0)
                store(xy, y, tile, row - begin, 1)


@inlined
def is_deformed(session, room):  # type: ignore[no-untyped-def]
    """Whether film changes from trial to trial."""
    return session.table_ends[-1] > 0 or room.field.shape[0] > 0


@kernel
def below_share(first, second, start, k0, k1, share, word, hit):  # type: ignore[no-untyped-def]
    """hit (tiles, WIDTH): 1 where the word of a trial from `start` on lies below `share`, else 0; True if any does.

    word (4, 2 tiles) is scratch. Where none does, hit is left as it is.
    """
    low, least = np.uint64(start) >> np.uint64(2), share
    for c in range(word.shape[1]):
        w0, w1, w2, w3 = philox(first, second & WORD, low + np.uint64(c), second >> HALF, k0, k1)
        word[0, c], word[1, c], word[2, c], word[3, c] = w0, w1, w2, w3
        least = min(least, min(min(w0, w1), min(w2, w3)))
    if least >= share:
        return False
    for c in range(word.shape[1]):
        for j in range(4):
            hit[c // 2, 4 * (c % 2) + j] = 1.0 if word[j, c] < share else 0.0
    return True


@kernel
def gross_errors(first, second, start, session, room):  # type: ignore[no-untyped-def]
    """Draw the gross errors of a point; True if any trial has one. They are to be taken back afterwards: `no_gross`."""
    k = session.gross_key
    if not below_share(first, second, start, k[0], k[1], session.gross_share, room.word, room.hit):
        return False
    k = session.size_key
    draw(first, second, start, k[0], k[1], room.drawn)
    for tile in range(room.gross.shape[0]):
        for axis in range(2):
            size = session.gross_size * drawn_of(room.drawn, tile, axis)
            store(room.gross, load(room.hit, tile) * size, tile, axis)
    return True
