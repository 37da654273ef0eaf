"""Where image points are measured, and where known coordinates and approximate orientations predict them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from adjust.model import project, rotation_matrices
from simfield.block import Block, Floats, Indices

FEWEST_LANDED = 3
STEEP = 0.5
"""cosine to the vertical of a ray that says where its point lies on level ground"""


@dataclass(frozen=True, eq=False)
class PredictedRays:
    """Rays of images with an approximate orientation: image (k) and point (k) indices, xy (k, 2) mm, half (k) diagonals
    in mm; exterior (m, 6), interior (m, 3) and known (n, 3) predict them, NaN for points without coordinates.
    """

    image: Indices
    point: Indices
    xy: Floats
    half: Floats
    exterior: Floats
    interior: Floats
    known: Floats

    @classmethod
    def of(cls, block: Block) -> PredictedRays:
        """All of them; known are control and check points, the others are what their rays say."""
        o, p = block.observations, block.points
        rows = np.flatnonzero(np.isfinite(block.images.exterior[o.image]).all(axis=1))
        cameras = [block.cameras[c] for c in block.images.camera]
        diagonal = np.array([0.5 * np.hypot(c.width_mm, c.height_mm) for c in cameras])
        return cls(
            o.image[rows],
            o.point[rows],
            o.xy[rows],
            diagonal[o.image[rows]],
            block.images.exterior,
            np.array([(c.c_mm, c.x0_mm, c.y0_mm) for c in cameras]),
            np.where((p.role == "tie")[:, None], np.nan, p.coordinates),
        )

    def misses(self) -> Floats:
        """(k) distance of measured from predicted in half diagonals; infinite behind a camera, NaN where nothing is
        predicted.
        """
        known = self._on_the_ground()
        with np.errstate(all="ignore"):
            xy, depth = project(self.exterior, self.interior, known[self.point], self.image)
            miss = np.hypot(*(self.xy - xy).T) / self.half
        behind = ~((depth > 0.0) & np.isfinite(miss))
        return np.where(np.isfinite(known[self.point]).all(axis=1), np.where(behind, np.inf, miss), np.nan)

    def _on_the_ground(self) -> Floats:
        """(n, 3) known coordinates; of other points the middle of where three rays or more meet the mean ground."""
        height = self.known[:, 2][np.isfinite(self.known[:, 2])]
        open_points = np.asarray(np.isnan(self.known).any(axis=1))
        if not len(height) or not open_points.any():
            return self.known
        c, principal = self.interior[self.image, :1], self.interior[self.image, 1:]
        ray = np.einsum(
            "kij,kj->ki", rotation_matrices(self.exterior[:, 3:])[self.image], np.hstack([self.xy - principal, -c])
        )
        station = self.exterior[self.image, :3]
        downward: Floats = -ray[:, 2] / np.linalg.norm(ray, axis=1)
        steep = np.logical_and(downward > STEEP, open_points[self.point])
        steep = np.logical_and(steep, station[:, 2] > np.median(height))
        rows = np.flatnonzero(steep)
        reach = (np.median(height) - station[rows, 2]) / ray[rows, 2]
        landed = station[rows, :2] + reach[:, None] * ray[rows, :2]
        known = self.known.copy()
        for axis in range(2):
            known[open_points, axis] = group_medians(landed[:, axis], self.point[rows], len(known), FEWEST_LANDED)[
                open_points
            ]
        known[open_points, 2] = np.where(np.isfinite(known[open_points, 0]), np.median(height), np.nan)
        return known

    def of_known(self) -> PredictedRays:
        """Those to control and check points."""
        return self.only(np.flatnonzero(np.isfinite(self.known[self.point]).all(axis=1)))

    def mean_miss(self) -> float:
        """Over the rays of known points or over the others, whichever is larger; a half diagonal at the most."""
        misses, known = np.minimum(self.misses(), 1.0), np.isfinite(self.known[self.point]).all(axis=1)
        parts = [misses[rows & ~np.isnan(misses)] for rows in (known, ~known)]
        return max((float(part.mean()) for part in parts if len(part)), default=1.0)

    def only(self, rows: Indices) -> PredictedRays:
        """Some of them."""
        return replace(self, image=self.image[rows], point=self.point[rows], xy=self.xy[rows], half=self.half[rows])


def group_medians(values: Floats, group: Indices, count: int, least: int = 1) -> Floats:
    """(count) the median of the values (k) of each group (k), NaN for groups of fewer than `least`."""
    order = np.lexsort((values, group))
    size = np.bincount(group, minlength=count)
    first = np.cumsum(size) - size
    known = size >= least
    found = np.full(count, np.nan)
    ranked = values[order]
    lower, upper = (first + (size - 1) // 2)[known], (first + size // 2)[known]
    with np.errstate(invalid="ignore"):  # rays behind a camera miss by infinity
        found[known] = 0.5 * (ranked[lower] + ranked[upper])
    return found
