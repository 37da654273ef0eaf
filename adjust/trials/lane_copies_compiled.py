"""Trials into lanes and back, compiled: numpy would make a copy for every change of order.

Trial t of a block is lane t % WIDTH of tile t // WIDTH.

Readable form: `adjust.trials.lane_copies`. Agreement: `tests/agreement/test_compiled_twins.py`.
"""

from __future__ import annotations

from typing import Any

import numba

from simfield.numerics import WIDTH, machine_code

machine_code.install()


@numba.njit(cache=True)
def transpose(image_points: Any, order: Any, lanes: Any) -> None:
    """lanes[t // WIDTH, k, :, t % WIDTH] = image_points[t, order[k], :]."""
    for t in range(image_points.shape[0]):
        tile = lanes[t // WIDTH]
        for k in range(order.size):
            tile[k, 0, t % WIDTH] = image_points[t, order[k], 0]
            tile[k, 1, t % WIDTH] = image_points[t, order[k], 1]


@numba.njit(cache=True)
def untile(x: Any, trials: Any) -> None:
    """trials[t] = x[t // WIDTH, :, t % WIDTH]; trials (t, size), x (tiles, size, WIDTH)."""
    for tile in range((trials.shape[0] + WIDTH - 1) // WIDTH):
        first = WIDTH * tile
        count = min(WIDTH, trials.shape[0] - first)
        for row in range(trials.shape[1]):
            for t in range(count):
                trials[first + t, row] = x[tile, row, t]


@numba.njit(cache=True)
def give(coordinates: Any, origin: Any, fixed: Any, first: Any, given: Any, start: Any, x: Any) -> None:
    """Coordinates (t, n, 3) of every trial, reduced by origin (3), into given (tiles, 3n, WIDTH).

    What is fixed (3n) also goes into start and x (tiles, size, WIDTH), whose points begin with row `first`. A lane
    without a trial repeats the first one.
    """
    count = coordinates.shape[0]
    for tile in range(given.shape[0]):
        for row in range(fixed.size):
            point, axis = row // 3, row % 3
            for lane in range(WIDTH):
                t = WIDTH * tile + lane
                given[tile, row, lane] = coordinates[t if t < count else 0, point, axis] - origin[axis]
            if fixed[row]:
                start[tile, first + row] = given[tile, row]
                x[tile, first + row] = given[tile, row]
