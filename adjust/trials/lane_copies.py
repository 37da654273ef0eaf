"""Trials into lanes and back in plain numpy: what `lane_copies_compiled` does without a copy for every change of order.

Trial t of a block is lane t % WIDTH of tile t // WIDTH.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from simfield.block import Floats, Indices
from simfield.numerics import WIDTH


def transpose(image_points: Floats, order: Indices, lanes: Floats) -> None:
    """Put trials (t, k, 2), their observations in this order (k), into lanes (tiles, k, 2, WIDTH)."""
    for t, trial in enumerate(image_points):
        lanes[t // WIDTH, :, :, t % WIDTH] = trial[order]


def untile(x: Floats, trials: Floats) -> None:
    """Put x (tiles, size, WIDTH) into trials (t, size)."""
    trials[:] = x.transpose(0, 2, 1).reshape(-1, x.shape[1])[: len(trials)]


def give(
    coordinates: Floats,
    origin: Floats,
    fixed: npt.NDArray[np.bool_],
    first: int,
    given: Floats,
    start: Floats,
    x: Floats,
) -> None:
    """Coordinates (t, n, 3) of every trial, reduced by origin (3), into given (tiles, 3n, WIDTH).

    What is fixed (3n) also goes into start and x (tiles, size, WIDTH), whose points begin with row `first`. A lane
    without a trial repeats the first one.
    """
    lanes = np.zeros(len(given) * WIDTH, dtype=int)
    lanes[: len(coordinates)] = np.arange(len(coordinates))
    reduced = (coordinates - origin).reshape(len(coordinates), -1)[lanes]
    given[:] = reduced.reshape(len(given), WIDTH, -1).transpose(0, 2, 1)
    rows = np.flatnonzero(fixed)
    start[:, first + rows] = given[:, rows]
    x[:, first + rows] = given[:, rows]
