"""Image coordinates of a block of trials, drawn once and shared by all methods that adjust them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from simfield import World
from simfield.block import Floats, Indices
from simfield.numerics import WIDTH


def image_points(world: World, trials: Sequence[int]) -> Floats:
    """(tiles, k, 2, 8) measured image coordinates, mm: the one place where trials are drawn.

    Trial number t of those asked for is lane t % 8 of tile t // 8, as `DrawnTrials` and the kernels want it.
    """
    tiles = np.empty((-(-len(trials) // WIDTH), len(world.image), 2, WIDTH))
    numbers = np.asarray(trials)
    first = 0
    for run in np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1):
        draws = world.draws(int(run[0]), int(run[-1]) + 1)
        if len(run) == len(numbers):
            draws.fill_lanes(slice(0, len(run)), tiles)
        else:
            put(tiles, range(first, first + len(run)), draws[:])
        first += len(run)
    return tiles


def put(tiles: Floats, places: Sequence[int], rows: Floats) -> None:
    """Put trials (t, k, 2) at these places into tiles."""
    for place, row in zip(places, rows, strict=True):
        tiles[place // WIDTH, :, :, place % WIDTH] = row


def repeated(coordinates: Floats, count: int) -> Floats:
    """The same coordinates (k, 2) for every trial, in tiles."""
    return np.repeat(np.repeat(coordinates[None, :, :, None], WIDTH, axis=3), -(-count // WIDTH), axis=0)


@dataclass(frozen=True, eq=False)
class DrawnTrials:
    """Trials that have been drawn: tiles (tiles, k, 2, 8), how many of their lanes count, and the observations that
    belong to a method. It is what `adjust.trials.replicates` calls image point trials.
    """

    tiles: Floats
    count: int
    rows: Indices

    def __len__(self) -> int:
        return self.count

    def only(self, rows: Indices) -> DrawnTrials:
        """The same trials of these observations alone; nothing is copied."""
        return DrawnTrials(self.tiles, self.count, self.rows[rows])

    def __getitem__(self, trials: slice) -> Floats:
        """(t, k, 2)."""
        places = np.arange(self.count)[trials]
        return np.asarray(self.tiles[places // WIDTH, :, :, places % WIDTH][:, self.rows])

    def fill_lanes(self, trials: slice, lanes: Floats) -> None:
        """Copy into lanes (tiles, k, 2, 8); a slice begins with a tile."""
        if trials.start % WIDTH:
            raise ValueError(f"a slice begins with a tile, found trial {trials.start}")
        first, last = trials.start // WIDTH, -(-trials.stop // WIDTH)
        np.take(self.tiles[first:last], self.rows, axis=1, out=lanes[: last - first], mode="clip")
