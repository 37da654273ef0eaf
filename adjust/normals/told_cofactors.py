"""Cofactors of the angles that people see, where those that are unknowns are reckoned by renamed object axes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from adjust.normals.cofactors import Cofactors
from simfield.block import Floats, Indices


@dataclass(frozen=True, eq=False)
class ToldCofactors(Cofactors):
    """T Q T^T, where T is unity but for the angles of some images: working is Q, images (r) these images, turns (r, 3,
    3) the derivatives of their omega, phi, kappa by those that are unknowns.
    """

    working: Cofactors
    images: Indices
    turns: Floats

    def _angles(self, image: int) -> Indices:
        return 6 * image + 3 + np.arange(3)

    @cached_property
    def orientation(self) -> Floats:
        told = self.working.orientation.copy()
        for image, turn in zip(self.images, self.turns, strict=True):
            at = self._angles(image)
            told[at] = turn @ told[at]
            told[:, at] = told[:, at] @ turn.T
        return told

    @property
    def points(self) -> Floats:
        return self.working.points

    @cached_property
    def diagonal(self) -> Floats:
        told = self.working.diagonal.copy()
        for image, turn in zip(self.images, self.turns, strict=True):
            at = self._angles(image)
            told[at] = np.diag(turn @ self.working.block(at, at) @ turn.T)
        return told

    def block(self, rows: Indices, columns: Indices) -> Floats:
        (above, left), (beside, right) = self._spread(rows), self._spread(columns)
        return np.asarray(left @ self.working.block(above, beside) @ right.T)

    def _spread(self, wanted: Indices) -> tuple[Indices, Floats]:
        """Places in x, and the matrix (len(wanted), places) that makes of their values those that are told."""
        seen = np.flatnonzero(np.isin(self.images, wanted[wanted < 6 * len(self.unknowns.block.images)] // 6))
        angles = [self._angles(int(self.images[number])) for number in seen]
        places = np.unique(np.concatenate([wanted, *angles]).astype(np.intp))
        told = np.eye(len(places))
        for number, at in zip(seen, angles, strict=True):
            mine = np.searchsorted(places, at)
            told[np.ix_(mine, mine)] = self.turns[number]
        return places, told[np.searchsorted(places, wanted)]
