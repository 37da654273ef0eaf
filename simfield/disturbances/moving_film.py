"""Image points on film that is deformed anew in every trial, for blocks of trials
(simfield.disturbances.film_compiled).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from simfield import disturbances  # the door, so that the compiled half is loaded when it is first needed
from simfield.block import Floats, Indices
from simfield.disturbances.distortion import DistortionError
from simfield.disturbances.expansion import second_order
from simfield.disturbances.film import FilmTable, film_monomials

STEEPEST, LARGEST_MM = 0.1, 2.0
LARGEST_SIGMA = 6.7
"""the farthest that numbers by counter go"""


@dataclass(frozen=True, eq=False)
class MovingFilm:
    """Points place (k, 2) mm with the deformation that all trials share, local (k, 2, 5) around it; image (k)."""

    place: Floats
    local: Floats
    image: Indices
    table: FilmTable
    images: int

    @classmethod
    def of(
        cls, place: Floats, shared: Callable[[Floats], Floats], image: Indices, table: FilmTable, images: int
    ) -> MovingFilm:
        """shared: the displacement that all trials share. Raises DistortionError where the film may be too steep."""
        local = second_order(shared, place)
        refuse_steep(table, place, local)
        return cls(place, local, image, table, images)

    def only(self, rows: Indices) -> MovingFilm:
        """Of these points alone."""
        return replace(self, place=self.place[rows], local=self.local[rows], image=self.image[rows])

    def add_to(self, lanes: Floats, start: int) -> None:
        """Add the points of the trials from `start` on, a multiple of 16, to lanes (tiles, k, 2, 8)."""
        rows = np.argsort(self.image, kind="stable")
        ends = np.searchsorted(self.image[rows], np.arange(self.images + 1))
        t = self.table
        table_ends = np.searchsorted(t.image, np.arange(self.images + 1))
        disturbances.add_film(
            lanes, start, rows, ends, self.place, self.local, table_ends, t.column, t.sigma, t.key, t.owner
        )


def refuse_steep(table: FilmTable, place: Floats, local: Floats) -> None:
    """Raises DistortionError where the largest film of the table over places (k, 2) is no small deformation."""
    if not len(place) or not len(table.image):
        return
    far = np.abs(place).max(axis=0)
    largest = table.coefficients(LARGEST_SIGMA * table.sigma, int(table.image.max()) + 1).max(axis=0)
    h = 1e-3
    at, in_x, in_y = film_monomials(far + np.array([[0.0, 0.0], [h, 0.0], [0.0, h]]))
    slope = float((largest @ np.column_stack([in_x - at, in_y - at]) / h).sum(axis=1).max())
    slope += float(np.abs(local[:, :, :2]).sum(axis=2).max())
    amount = float((largest @ at).max())
    if slope > STEEPEST or amount > LARGEST_MM:
        raise DistortionError(
            f"film that may move by {amount:.2g} mm and be as steep as {slope:.2g} is too much for many trials at "
            f"once, which take up to {LARGEST_MM:g} mm and {STEEPEST:g}"
        )
