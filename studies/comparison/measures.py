"""How far an estimate is from what it should be: the one place where truth and estimate meet.

Deviations are estimated minus reference, in metres. Two references are possible: the geodetic coordinates that stand in
the block, which is all that a real experiment has, and the true ones, which only a simulation knows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from adjust import Adjustment
from simfield import Truth
from simfield.block import Floats

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Deviations:
    """Root mean squares of n points' deviations, m; NaN where no point has a reference.

    rms_xy_m is the two-dimensional point error sqrt(rms_x^2 + rms_y^2), rms_xy_coordinate_m that of one coordinate,
    smaller by sqrt(2).
    """

    n: int
    rms_x_m: float
    rms_y_m: float
    rms_z_m: float

    @classmethod
    def of(cls, differences: Floats) -> Deviations:
        """From differences (n, 3), m; NaN is a missing coordinate, and a point without any is not counted."""
        n = int(np.isfinite(differences).any(axis=1).sum())
        return cls(n, *(root_mean_square(column) for column in differences.T))

    @property
    def rms_xy_m(self) -> float:
        return float(np.hypot(self.rms_x_m, self.rms_y_m))

    @property
    def rms_xy_coordinate_m(self) -> float:
        return float(self.rms_xy_m / np.sqrt(2.0))


@dataclass(frozen=True)
class CheckPoints:
    """Check points compared: `geodetic` against the coordinates in the block, `true` against the truth.

    coverage_x, _y, _z is the share of the 95 % confidence intervals that contain the true coordinate (NaN without
    points). The rms of the geodetic comparison can be read directly, rms_z_m and so on, as a paper reports them.
    """

    geodetic: Deviations
    true: Deviations
    coverage_x: float
    coverage_y: float
    coverage_z: float

    @property
    def n(self) -> int:
        return self.geodetic.n

    @property
    def rms_x_m(self) -> float:
        return self.geodetic.rms_x_m

    @property
    def rms_y_m(self) -> float:
        return self.geodetic.rms_y_m

    @property
    def rms_z_m(self) -> float:
        return self.geodetic.rms_z_m

    @property
    def rms_xy_m(self) -> float:
        return self.geodetic.rms_xy_m

    @property
    def rms_xy_coordinate_m(self) -> float:
        return self.geodetic.rms_xy_coordinate_m


def check_points(a: Adjustment, truth: Truth) -> CheckPoints:
    """Compare the check points of an adjustment with their geodetic and their true coordinates.

    Raises KeyError if the truth lacks one of them.
    """
    rows = a.block.points.role == "check"
    ids = [name for name, chosen in zip(a.block.points.ids, rows, strict=True) if chosen]
    place = {name: row for row, name in enumerate(truth.point_ids)}
    true = truth.coordinates[[place[name] for name in ids]].reshape(-1, 3)
    error = a.points.values[rows] - true
    inside = covered(error, a.points.std[rows], a.redundancy)
    return CheckPoints(geodetic_deviations(a), Deviations.of(error), *(float(share) for share in inside))


def geodetic_deviations(a: Adjustment) -> Deviations:
    """The check points against their coordinates in the block; needs no truth, and no standard deviations."""
    rows = a.block.points.role == "check"
    estimated = a.layout.points(a.x)[rows] + a.layout.origin
    return Deviations.of(estimated - a.block.points.coordinates[rows])


def covered(error: Floats, std: Floats, redundancy: int, confidence: float = CONFIDENCE) -> Floats:
    """The share of each column's intervals +- t std (n, c) that contain an error (n, c) of zero; NaN without rows.

    t is Student's quantile for the redundancy, since the standard deviations contain the estimated sigma0.
    """
    if len(error) == 0:
        return np.full(error.shape[1], np.nan)
    t = stdtrit(redundancy, 0.5 + confidence / 2.0)
    return np.asarray(np.mean(np.abs(error) <= t * std, axis=0))


def root_mean_square(values: npt.ArrayLike) -> float:
    """The quadratic mean of all finite values; NaN if there is none."""
    array = np.asarray(values, float)
    array = array[np.isfinite(array)]
    return float(np.sqrt(np.mean(array**2))) if array.size else float("nan")
