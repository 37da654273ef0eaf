"""The comparator's own errors: double measurement, drift, scale and non-orthogonality of its axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from adjust.reductions.reduced_points import Reduced
from simfield.block import Floats, Indices


@dataclass(frozen=True, eq=False)
class DoubleMeasurement:
    """mean (k, 2) and difference (k, 2), second minus first, mm; doubtful (k) differences beyond the threshold.

    sigma_um: the standard deviation of one setting, from the differences that are not doubtful.
    """

    mean: Floats
    difference: Floats
    doubtful: npt.NDArray[np.bool_]
    sigma_um: float


def double_measurement(settings: Floats, threshold_um: float = 15.0) -> DoubleMeasurement:
    """Check and average settings (k, s, 2) mm, s = 1 or 2. Raises ValueError for another number of settings."""
    if settings.ndim != 3 or settings.shape[1] not in (1, 2):
        raise ValueError(f"needed are one or two settings of every point, found the shape {settings.shape}")
    difference = settings[:, -1] - settings[:, 0]
    doubtful = np.asarray((np.abs(difference) > threshold_um / 1000.0).any(axis=1))
    sound = difference[~doubtful]
    single = settings.shape[1] == 1 or not sound.size
    sigma = float("nan") if single else 1000.0 * float(np.sqrt(0.5 * np.mean(sound**2)))
    return DoubleMeasurement(settings.mean(axis=1), difference, doubtful, sigma)


@dataclass(frozen=True, eq=False)
class Drift:
    """A linear drift (m, 2) of every image over its session, mm."""

    rate: Floats

    def removed_from(self, xy: Floats, image: Indices, time: Floats) -> Reduced:
        """Points xy (k, 2) in the images (k), set at times (k) from 0 to 1."""
        return Reduced.by(xy, xy - time[:, None] * self.rate[image])


def drift(xy: Floats, image: Indices, mark: Indices, time: Floats, images: int) -> Drift:
    """The drift by the marks that were set more than once: xy (f, 2), image, mark, time (f) of all settings of marks.

    Least squares of a constant for every mark and image and a rate for every image; 0 where no mark was repeated.
    """
    key = image * (int(mark.max(initial=0)) + 1) + mark
    _, owner, count = np.unique(key, return_inverse=True, return_counts=True)
    mean_time = np.bincount(owner, time) / count
    centred = time - mean_time[owner]
    means = np.stack([np.bincount(owner, xy[:, axis]) / count for axis in (0, 1)], axis=1)
    above = np.stack(
        [np.bincount(image, centred * (xy - means[owner])[:, axis], minlength=images) for axis in (0, 1)], axis=1
    )
    below = np.bincount(image, centred**2, minlength=images)[:, None]
    return Drift(np.divide(above, below, out=np.zeros_like(above), where=below > 0.0))


def calibrated(xy: Floats, scale_x_ppm: float, scale_y_ppm: float, non_orthogonality_ppm: float) -> Reduced:
    """Machine coordinates xy (k, 2) turned into rectangular ones of true scale.

    The machine shows u = (1 + sx) x + g y, v = (1 + sy) y; solved from below.
    """
    y = xy[:, 1] / (1.0 + 1e-6 * scale_y_ppm)
    x = (xy[:, 0] - 1e-6 * non_orthogonality_ppm * y) / (1.0 + 1e-6 * scale_x_ppm)
    return Reduced.by(xy, np.column_stack([x, y]))
