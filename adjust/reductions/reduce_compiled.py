"""Reductions of some tiles of trials, in lanes: drift, comparator, inner orientation and reseau, image by image.

The marks of an image are taken first, and say what
is done to its points (`oriented`); then points are reduced one by one (`reduced`). The arithmetic of a trial does not
depend on its neighbours.

Readable form: `adjust.reductions.reduction.reduce`. Agreement: `tests/agreement/test_measured_trials.py`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from adjust.reductions.inner import PARAMETERS, UNIT_MM, Kind
from adjust.reductions.inner_compiled import KINDS, MOST_LINEAR, find_parameters, transformed
from adjust.reductions.reseau_crosses_compiled import MOST_DEGREE, MOST_POWERS, MOST_TERMS, fit_reseau, without_shift
from simfield.block import Floats, Indices
from simfield.numerics import WIDTH, Arena, align_stack, inlined, kernel, load, store

NO_KIND = -1
RATE, CENTRE, ROWS = 8, 10, 12
"""rows of what is known of an image: the parameters of its inner orientation in 0 .. 7, the drift a unit of time in x
and y, the centre of the fiducials in x and y"""


class Frame(NamedTuple):
    """How images are reduced. The s settings of marks stand in the same order in every image.

    drift_weight (m, s): of the settings in an image's drift, 1/mm; 0 where no drift is taken out. by_x, by_y: one over
    the scales of the machine, and its shear; 1, 1, 0 where it is not calibrated. kind: of the inner orientation,
    NO_KIND for none; fiducial (f) settings it is found by. places (m, s, 2) mm of the marks. degree: of the reseau
    correction, 0 for none; cross (r): settings it is found by.
    """

    drift_weight: Floats
    by_x: float
    by_y: float
    shear: float
    kind: int
    fiducial: Indices
    places: Floats
    degree: int
    cross: Indices

    @classmethod
    def of(
        cls, kind: Kind, drift_weight: Floats, machine: tuple[float, float, float], places: Floats,
        fiducial: Indices, degree: int, cross: Indices,
    ) -> Frame:  # fmt: skip
        """machine: scales in x and y, and shear, all 0 where it is not calibrated; degree 0: no reseau correction.

        Raises ValueError for too few fiducials or crosses, and for a degree that normal equations cannot bear.
        """
        if 2 * len(fiducial) < PARAMETERS[kind]:
            raise ValueError(f"{kind} needs {PARAMETERS[kind] // 2} fiducials, there are {len(fiducial)} settings")
        if degree > MOST_DEGREE:
            raise ValueError(f"for many trials the degree of the reseau correction is at most {MOST_DEGREE}")
        terms = (degree + 1) * (degree + 2) // 2
        if degree > 0 and len(cross) < terms:
            raise ValueError(f"degree {degree} needs {terms} crosses, there are {len(cross)}")
        x, y, shear = machine
        return cls(
            drift_weight, 1.0 / (1.0 + x), 1.0 / (1.0 + y), shear, KINDS.index(kind), fiducial, places, degree, cross
        )

    @classmethod
    def nothing_reduced(cls, images: int, settings: int) -> Frame:
        """Machine coordinates are left as they are."""
        none = np.zeros(0, dtype=np.intp)
        weights, places = np.zeros((images, settings)), np.zeros((images, settings, 2))
        return cls(weights, 1.0, 1.0, 0.0, NO_KIND, none, places, 0, none)


class Work(NamedTuple):
    """Room for the equations of an image and a tile, and what is found for all tiles.

    known (tiles, ROWS, WIDTH) and shift (tiles, MOST_TERMS, 2, WIDTH), the correction by the reseau, are found.
    """

    known: Floats
    shift: Floats
    normal: Floats
    gradient: Floats
    row: Floats
    power: Floats
    right: Floats
    moment: Floats

    @classmethod
    def of(cls, tiles: int, arena: Arena) -> Work:
        """For so many tiles."""
        return cls(
            arena.zeros(tiles, ROWS, WIDTH),
            arena.zeros(tiles, MOST_TERMS, 2, WIDTH),
            arena.zeros(MOST_TERMS, MOST_TERMS, WIDTH),
            arena.zeros(MOST_LINEAR, 2, WIDTH),
            arena.zeros(MOST_LINEAR, WIDTH),
            arena.zeros(MOST_POWERS, 2, WIDTH),
            arena.zeros(2, WIDTH),
            arena.zeros(MOST_POWERS, MOST_POWERS, WIDTH),
        )


def drift_weights(image: Indices, mark: Indices, time: Floats, images: int) -> Floats:
    """(m, s): the drift of an image is the sum of these times its settings. See `adjust.reductions.drift`."""
    of_image = [np.flatnonzero(image == i) for i in range(images)]
    weights = np.zeros((images, len(of_image[0])))
    for i, rows in enumerate(of_image):
        _, owner, count = np.unique(mark[rows], return_inverse=True, return_counts=True)
        centred = time[rows] - (np.bincount(owner, time[rows]) / count)[owner]
        square = float(centred @ centred)
        weights[i] = centred / square if square > 0.0 else 0.0
    return weights


@kernel
def oriented(i, frame, mark_time, marks, work):  # type: ignore[no-untyped-def]
    """Find what is known of image i from marks (tiles, s, 2, WIDTH), mm on the machine, which are reduced in place."""
    align_stack()
    for tile in range(marks.shape[0]):
        known, own = work.known[tile], marks[tile]
        known[:] = 0.0
        rate_x, rate_y = load(known, RATE), load(known, RATE + 1)
        for s in range(len(mark_time)):
            w = frame.drift_weight[i, s]
            if w != 0.0:
                rate_x, rate_y = rate_x + w * load(own, s, 0), rate_y + w * load(own, s, 1)
        store(known, rate_x, RATE)
        store(known, rate_y, RATE + 1)
        if frame.kind == NO_KIND:
            continue
        centre_x, centre_y, share = load(known, CENTRE), load(known, CENTRE + 1), 1.0 / len(frame.fiducial)
        for s in range(len(mark_time)):
            x, y = _rectangular(frame, work.known, tile, mark_time[s], load(own, s, 0), load(own, s, 1))
            store(own, x, s, 0)
            store(own, y, s, 1)
        for s in frame.fiducial:
            centre_x, centre_y = centre_x + share * load(own, s, 0), centre_y + share * load(own, s, 1)
        store(known, centre_x, CENTRE)
        store(known, centre_y, CENTRE + 1)
        for s in range(len(mark_time)):
            store(own, (load(own, s, 0) - centre_x) * (1.0 / UNIT_MM), s, 0)
            store(own, (load(own, s, 1) - centre_y) * (1.0 / UNIT_MM), s, 1)
        find_parameters(frame.kind, frame.fiducial, frame.places[i], own, known, work)
        if frame.degree > 0:
            for s in frame.cross:
                x, y = transformed(frame.kind, work.known, tile, load(own, s, 0), load(own, s, 1))
                store(own, x, s, 0)
                store(own, y, s, 1)
            fit_reseau(frame.degree, frame.cross, frame.places[i], own, work, work.shift[tile])


@inlined
def reduced(frame, time, x, y, tile, work):  # type: ignore[no-untyped-def]
    """Lanes (x, y) mm of a point on the machine, set at `time`, in the frame of the marks of its image."""
    x, y = _rectangular(frame, work.known, tile, time, x, y)
    if frame.kind != NO_KIND:
        x, y = (
            (x - load(work.known, tile, CENTRE)) * (1.0 / UNIT_MM),
            (y - load(work.known, tile, CENTRE + 1)) * (1.0 / UNIT_MM),
        )
        x, y = transformed(frame.kind, work.known, tile, x, y)
        if frame.degree > 0:
            x, y = without_shift(frame.degree, work.shift, tile, x, y)
    return x, y


@inlined
def _rectangular(frame, known, tile, time, x, y):  # type: ignore[no-untyped-def]
    """Lanes (x, y) without drift, on rectangular axes of true scale."""
    y = (y - time * load(known, tile, RATE + 1)) * frame.by_y
    return ((x - time * load(known, tile, RATE)) - frame.shear * y) * frame.by_x, y
