"""Given coordinates with standard deviations: observations of themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adjust.model import Unknowns
from simfield.block import Block, Floats, Indices


@dataclass(frozen=True, eq=False)
class ControlCoordinates:
    """Weighted control: coordinates that are observations of themselves. columns (q) in x, given and weight (q).

    coordinates (q) counts all coordinates of all points, three a point.
    """

    coordinates: Indices
    columns: Indices
    given: Floats
    weight: Floats

    @classmethod
    def of(cls, block: Block, unknowns: Unknowns) -> ControlCoordinates:
        at = np.flatnonzero(block.points.weighted.ravel())
        given = (block.points.coordinates - unknowns.origin).ravel()[at]
        return cls(at, unknowns.places[at], given, 1.0 / block.points.sigma.ravel()[at] ** 2)

    def residuals(self, x: Floats) -> Floats:
        """v (q), m."""
        return x[self.columns] - self.given
