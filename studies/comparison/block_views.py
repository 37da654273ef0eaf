"""What figures show of a block and of its adjustment: footprints on the ground, error ellipses, mean residuals."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adjust import Adjustment
from adjust.model import rotation_matrices
from simfield.block import Block, Floats, Indices
from studies.comparison.distortion_found import VectorField


def footprints(block: Block, ground_m: float | None = None) -> Floats:
    """(m, 4, 2) X, Y of the format's corners on a level ground, m; NaN where a corner does not look down.

    ground_m is its height, the mean height of the points with coordinates if None. The exterior orientations are the
    approximate ones of the block.
    """
    if ground_m is None:
        ground_m = float(np.nanmean(block.points.coordinates[:, 2]))
    exterior = block.images.exterior
    corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    found = np.full((len(block.images), 4, 2), np.nan)
    for number, camera in enumerate(block.cameras):
        own = np.flatnonzero(block.images.camera == number)
        xy = corners * (camera.width_mm, camera.height_mm) - (camera.x0_mm, camera.y0_mm)
        rays = np.column_stack([xy, np.full(4, -camera.c_mm)])
        seen = np.einsum("mij,kj->mki", rotation_matrices(exterior[own, 3:]), rays)
        fall = np.where(seen[..., 2] < 0.0, seen[..., 2], np.nan)
        reach = (ground_m - exterior[own, None, 2]) / fall
        found[own] = exterior[own, None, :2] + reach[..., None] * seen[..., :2]
    return found


@dataclass(frozen=True, eq=False)
class PointErrors:
    """Standard error ellipses and height errors of n points.

    xy_m (n, 2) where they are; semi_m (n, 2) major and minor semi-axis; angle (n) of the major one, radians from X
    towards Y; height_m (n) standard deviation of the height.
    """

    xy_m: Floats
    semi_m: Floats
    angle: Floats
    height_m: Floats


def point_errors(a: Adjustment, rows: Indices | npt.NDArray[np.bool_]) -> PointErrors:
    """Of the points in the given rows of the block, from their covariances. Raises ValueError for a failed adjustment.

    One-sigma ellipses: a true position lies inside with a probability of 39 %.
    """
    ids = np.array(a.points.ids)[rows].tolist()
    xy = a.points.values[rows, :2]
    covariances = np.array([a.covariance(*((name, axis) for axis in ("X", "Y", "Z"))) for name in ids]).reshape(
        -1, 3, 3
    )
    values, directions = np.linalg.eigh(covariances[:, :2, :2])
    semi = np.sqrt(np.maximum(values[:, ::-1], 0.0))
    major = directions[:, :, 1]
    return PointErrors(xy, semi, np.arctan2(major[:, 1], major[:, 0]), np.sqrt(covariances[:, 2, 2]))


def mean_residuals(a: Adjustment, camera_id: str, cell_mm: float = 20.0, least: int = 3) -> VectorField:
    """The mean residual of a camera in square cells of its format, at the centres of the cells with `least` or more.

    What is the same in all images stands out and noise averages away: this is where a missing parameter shows. Raises
    StopIteration for an unknown camera.
    """
    number = next(n for n, camera in enumerate(a.block.cameras) if camera.camera_id == camera_id)
    own = a.block.images.camera[a.block.observations.image] == number
    cells, place, count = np.unique(
        np.floor(a.block.observations.xy[own] / cell_mm).astype(int), axis=0, return_inverse=True, return_counts=True
    )
    sums = np.zeros((len(cells), 2))
    np.add.at(sums, place.ravel(), a.residuals[own])
    kept = count >= least
    return VectorField((cells[kept] + 0.5) * cell_mm, 1000.0 * sums[kept] / count[kept, None])


def ap_exterior_correlations(a: Adjustment, camera_id: str, image_id: str) -> Floats:
    """(a, 6) correlations of a camera's additional parameters with the exterior orientation of an image."""
    parameters = [(camera_id, name) for name in a.ap[camera_id].names]
    exterior = [(image_id, name) for name in a.images.names]
    return a.correlation(*parameters, *exterior)[: len(parameters), len(parameters) :]
