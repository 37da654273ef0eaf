"""Image points on film that is deformed anew in every trial, for blocks of trials (simfield.compiled_film)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from simfield.block import Floats, Indices
from simfield.distortion import MOST_STEPS, DistortionError, FilmTable, film_monomials
from simfield.expansion import second_order

ERROR_LEFT_MM = 1e-10
LARGEST_SIGMA = 6.7
"""the farthest that numbers by counter go"""


@dataclass(frozen=True, eq=False)
class MovingFilm:
    """Points place (k, 2) mm with the deformation that all trials share, local (k, 2, 5) around it; image (k).

    steps: of the fixed-point iteration, as many as the largest deformation that can be drawn needs.
    """

    place: Floats
    local: Floats
    image: Indices
    table: FilmTable
    images: int
    steps: int

    @classmethod
    def of(
        cls, place: Floats, shared: Callable[[Floats], Floats], image: Indices, table: FilmTable, images: int
    ) -> MovingFilm:
        """shared: the displacement that all trials share. Raises DistortionError where the film may be too steep."""
        local = second_order(shared, place)
        return cls(place, local, image, table, images, steps_needed(table, place, local))

    def only(self, rows: Indices) -> MovingFilm:
        """Of these points alone."""
        return replace(self, place=self.place[rows], local=self.local[rows], image=self.image[rows])

    def add_to(self, lanes: Floats, start: int) -> None:
        """Add the points of the trials from `start` on, a multiple of 16, to lanes (tiles, k, 2, 8)."""
        from simfield.compiled_film import add_film

        rows = np.argsort(self.image, kind="stable")
        ends = np.searchsorted(self.image[rows], np.arange(self.images + 1))
        t = self.table
        table_ends = np.searchsorted(t.image, np.arange(self.images + 1))
        add_film(
            lanes, start, rows, ends, self.place, self.local, table_ends, t.column, t.sigma, t.key, t.owner, self.steps
        )


def steps_needed(table: FilmTable, place: Floats, local: Floats) -> int:
    """Steps after which the largest film of the table over places (k, 2) has settled to ERROR_LEFT_MM.

    Raises DistortionError where it may not settle.
    """
    if not len(place):
        return 1
    far = np.abs(place).max(axis=0)
    sizes = np.zeros((int(table.image.max(initial=0)) + 1, 2, 9))
    np.add.at(sizes, (table.image, slice(None), table.column), LARGEST_SIGMA * table.sigma)
    largest = sizes.max(axis=0)
    amount = float((largest @ film_monomials(far[None])[0]).max())
    h = 1e-3
    steeper = film_monomials(far + np.array([[h, 0.0], [0.0, h]])) - film_monomials(far[None])
    slope = float((largest @ (steeper.T / h)).sum(axis=1).max()) + float(np.abs(local[:, :, :2]).sum(axis=2).max())
    if slope >= 0.85:
        raise DistortionError(f"film that may be as steep as {slope:.2g} cannot be solved for")
    if amount == 0.0 or slope == 0.0:
        return 2
    return min(2 + int(np.ceil(np.log(ERROR_LEFT_MM / amount) / np.log(slope))), MOST_STEPS)
