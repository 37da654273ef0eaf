"""Image coordinates of many trials, drawn when they are asked for.

The numbers are those of `World.image_points`, trial by trial and bit by bit: they hang on key and counter alone
(simfield.counter_normals), so neither the order of drawing nor the size of a slice matters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from simfield.block import Floats, Indices
from simfield.counter_normals import Words, normal_pairs


@dataclass(frozen=True, eq=False)
class ImageNoise:
    """Normal errors of k observations: sigma (k) mm, a key of two 32-bit words, counters place (k) and image (k)."""

    sigma: Floats
    key: tuple[int, int]
    place: Words
    image: Words

    def of(self, trial: int) -> Floats:
        """(k, 2) the errors of one trial, mm."""
        return np.asarray(self.sigma[:, None] * normal_pairs(self.key, (self.place, self.image, trial, 0)))

    def only(self, rows: Indices) -> ImageNoise:
        """Of these observations alone."""
        return ImageNoise(self.sigma[rows], self.key, self.place[rows], self.image[rows])


@dataclass(frozen=True, eq=False)
class ImagePointDraws:
    """The trials start .. stop - 1, to be sliced like an array (t, k, 2) of image coordinates in mm.

    base (k, 2): coordinates without noise; moving gives those of a trial, where they differ from trial to trial.
    """

    base: Floats
    noise: ImageNoise
    start: int
    stop: int
    moving: Callable[[int], Floats] | None = None

    def __len__(self) -> int:
        return self.stop - self.start

    def only(self, rows: Indices) -> ImagePointDraws:
        """The same trials of these observations alone, as in a sub-block."""
        moving = None if self.moving is None else _Rows(self.moving, rows)
        return ImagePointDraws(self.base[rows], self.noise.only(rows), self.start, self.stop, moving)

    def __getitem__(self, trials: slice) -> Floats:
        """(t, k, 2). Raises ValueError for a step other than 1."""
        first, last, step = trials.indices(len(self))
        if step != 1:
            raise ValueError(f"trials come one after the other, found a step of {step}")
        drawn = np.empty((len(self.base), 2, max(last - first, 0)))
        self.fill_lanes(slice(first, max(first, last)), np.arange(len(self.base)), drawn)
        return np.ascontiguousarray(drawn.transpose(2, 0, 1))

    def fill_lanes(self, trials: slice, order: Indices, lanes: Floats) -> None:
        """Draw into lanes (k, 2, >= t), trials inmost, row r the observation order[r]."""
        from simfield.compiled_draws import fill

        numbers = np.arange(self.start + trials.start, self.start + trials.stop, dtype=np.uint64)
        n, sigma = self.noise, np.column_stack([self.noise.sigma, self.noise.sigma])[order]
        k0, k1 = (np.uint64(k) for k in n.key)
        base = self.base[order] if self.moving is None else np.zeros((len(order), 2))
        fill(lanes, base, sigma, n.place[order], n.image[order], numbers, k0, k1)
        if self.moving is not None:
            for lane, trial in enumerate(numbers):
                lanes[:, :, lane] += self.moving(int(trial))[order]


@dataclass(frozen=True, eq=False)
class _Rows:
    """Some rows of what a function of the trial returns; a class, so that it can travel to another process."""

    function: Callable[[int], Floats]
    rows: Indices

    def __call__(self, trial: int) -> Floats:
        return self.function(trial)[self.rows]
