"""The order of images in a banded matrix, and when a band is less work than a dense matrix."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg
import scipy.sparse

from adjust.observations import Observations
from simfield.block import Indices

BLAS_RATE, LOOP_RATE, BAND_RATE = 15.0, 1.2, 4.0
"""multiplications a nanosecond of dense products, of the loop over pairs of rays, and of the banded factorisation;
only their ratios matter, for the choice between a dense and a banded matrix"""


@dataclass(frozen=True, eq=False)
class Ordering:
    """The order of images in a banded matrix: place (m) of every image, half bandwidth in images, and rays by point."""

    place: Indices
    reach: int
    ray_starts: Indices
    rays: Indices

    @property
    def work(self) -> float:
        """About the time of a banded reduction and factorisation, ns."""
        size, width = 6.0 * len(self.place), 6.0 * (self.reach + 1)
        pairs = float(np.sum(np.diff(self.ray_starts) ** 2)) / 2
        return 108 * pairs / LOOP_RATE + size * width**2 / BAND_RATE

    @classmethod
    def of(cls, observations: Observations) -> Ordering:
        g = observations.image_points
        u = g.unknowns
        m, n = len(u.block.images), len(u.block.points)
        seen: Any = scipy.sparse.csr_array((np.ones(len(g.image)), (g.image, g.point)), shape=(m, n))
        shared = scipy.sparse.csr_array(seen @ seen.T)
        order = scipy.sparse.csgraph.reverse_cuthill_mckee(shared, symmetric_mode=True)
        place = np.empty(m, dtype=np.intp)
        place[order] = np.arange(m)
        pairs = shared.tocoo()
        reach = int(np.abs(place[pairs.coords[0]] - place[pairs.coords[1]]).max(initial=0))
        rays = np.argsort(g.point, kind="stable")
        return cls(place, reach, np.searchsorted(g.point[rays], np.arange(n + 1)), rays)
