"""Image coordinates of many trials, drawn when they are asked for.

The numbers are those of `World.image_points`, trial by trial and bit by bit (film that changes from trial to trial:
to 1e-11 mm): they hang on key and counter alone (simfield.random.counter_normals), so neither the order of drawing
nor the size of a slice matters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from simfield import random
from simfield.block import Floats, Indices
from simfield.disturbances.moving_film import MovingFilm
from simfield.numerics import WIDTH
from simfield.random import Words, normal_pairs


@dataclass(frozen=True, eq=False)
class ImageNoise:
    """Normal errors of k observations: sigma (k) mm, a key of two 32-bit words, counters place (k) and image (k)."""

    sigma: Floats
    key: tuple[int, int]
    place: Words
    image: Words

    def of(self, trial: int) -> Floats:
        """(k, 2) the errors of one trial, mm."""
        return np.asarray(self.sigma[:, None] * normal_pairs(self.key, self.place, self.image, trial))

    def only(self, rows: Indices) -> ImageNoise:
        """Of these observations alone."""
        return ImageNoise(self.sigma[rows], self.key, self.place[rows], self.image[rows])


@dataclass(frozen=True, eq=False)
class ImagePointDraws:
    """The trials start .. stop - 1, to be sliced like an array (t, k, 2) of image coordinates in mm.

    base (k, 2): coordinates without noise; moving has those of a trial, where they differ from trial to trial.
    """

    base: Floats
    noise: ImageNoise
    start: int
    stop: int
    moving: MovingFilm | None = None

    def __len__(self) -> int:
        return self.stop - self.start

    def only(self, rows: Indices) -> ImagePointDraws:
        """The same trials of these observations alone, as in a sub-block."""
        moving = None if self.moving is None else self.moving.only(rows)
        return ImagePointDraws(self.base[rows], self.noise.only(rows), self.start, self.stop, moving)

    def __getitem__(self, trials: slice) -> Floats:
        """(t, k, 2). Raises ValueError for a step other than 1."""
        first, last, step = trials.indices(len(self))
        if step != 1:
            raise ValueError(f"trials come one after the other, found a step of {step}")
        count = max(last - first, 0)
        drawn = np.empty((-(-count // WIDTH), len(self.base), 2, WIDTH))
        self.fill_lanes(slice(first, first + count), drawn)
        return np.ascontiguousarray(drawn.transpose(0, 3, 1, 2)).reshape(-1, len(self.base), 2)[:count]

    def fill_lanes(self, trials: slice, lanes: Floats) -> None:
        """Draw into lanes (tiles, k, 2, WIDTH).

        Trial number t of the slice comes into tile t // WIDTH, lane t % WIDTH; lanes beyond the slice are overwritten.
        """
        n, sigma = self.noise, np.column_stack([self.noise.sigma, self.noise.sigma])
        base = self.base if self.moving is None else np.zeros_like(self.base)
        number = self.start + trials.start
        early, tiles = number % random.PERIOD, len(lanes)
        whole = lanes if not early and not tiles % 2 else np.empty((tiles + 2 + tiles % 2, *lanes.shape[1:]))
        random.fill(whole, base, sigma, n.place, n.image, number - early, *(np.uint64(k) for k in n.key))
        if self.moving is not None:
            self.moving.add_to(whole, number - early)
        if whole is not lanes:
            in_a_row = whole.transpose(0, 3, 1, 2).reshape(-1, *base.shape)[early : early + WIDTH * tiles]
            lanes[:] = in_a_row.reshape(tiles, WIDTH, *base.shape).transpose(0, 2, 3, 1)
