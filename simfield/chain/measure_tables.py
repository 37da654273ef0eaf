"""What a prepared chain tells the compiled loops: places of points and marks, sorted by image, and the session."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from simfield.block import Floats, Indices
from simfield.chain.measure import KINDS, PreparedChain, share_of_words
from simfield.disturbances import FilmTable, measured_from_ideal, refuse_steep, second_order
from simfield.random import counter_key


class Places(NamedTuple):
    """Settings of one kind, points or marks, sorted by image: those of image i from ends[i] to ends[i + 1].

    place (n, 2) on the film with the deformation that all trials share, local (n, 2, 5) around it; modes (n, q) of the
    smooth field; time (n); sigma (n) of pointing and setting, mm; first (n) and second (n) counter words, and the two
    words of their key.
    """

    ends: Indices
    place: Floats
    local: Floats
    modes: Floats
    time: Floats
    sigma: Floats
    first: Any
    second: Any
    key: Any


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
    gross_share: Any
    gross_size: float
    gross_key: Any
    size_key: Any


def tables(prepared: PreparedChain, rows: Indices) -> tuple[Places, Places, Session]:
    """Of the image points `rows`, which are sorted by image, of all marks, and of the session."""
    world, k, m = prepared.world, prepared.count, len(prepared.world.plan)
    on_film = measured_from_ideal(prepared.exposed, prepared.constant_film)
    # the shared deformation is a function of all places at once, so it is expanded for all
    local = second_order(prepared.constant_film, on_film)
    modes = np.zeros((len(on_film), 0)) if prepared.field is None else prepared.field.modes
    words, places = prepared.image_words, prepared.place_words
    keys = (world.image_noise.key, counter_key(world.seed, "mark pointing", KINDS[1]))
    kinds = []
    for of, key in zip((rows, np.arange(k, len(on_film))), keys, strict=True):
        image = prepared.image[of]
        place, around, smooth, time, sigma = (
            np.ascontiguousarray(a[of]) for a in (on_film, local, modes, prepared.time, prepared.noise_sigma)
        )
        ends = np.searchsorted(image, np.arange(m + 1))
        kinds.append(Places(ends, place, around, smooth, time, sigma, places[of], words[image], _words(key)))
    return kinds[0], kinds[1], _session(prepared, on_film, local)


def _session(prepared: PreparedChain, on_film: Floats, local: Floats) -> Session:
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
        np.uint64(share_of_words(errors.gross_rate)),
        errors.gross_um / 1000.0,
        _words(counter_key(world.seed, "gross")),
        _words(counter_key(world.seed, "gross size")),
    )


def _words(key: tuple[int, int]) -> Any:
    return np.array(key, dtype=np.uint64)
