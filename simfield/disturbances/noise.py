"""Random errors of image coordinates and of the geodetic survey.

The noise of an observation hangs on the seed, the trial, the image's id and the point's number in the field alone: it
stays what it was when other images, other points or another camera's noise change.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from simfield.block import Floats, Indices
from simfield.disturbances.draws import ImageNoise
from simfield.random import counter_key, name_words, stream

PerCamera = float | Mapping[str, float]
"""One number for all cameras, or one for each camera id."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the random errors.

    image_um: of an image coordinate. assumed_um: what the block tells the adjustment about it (None: the truth).
    geodetic_mm: of a given coordinate of control and check points; images see the true points. If one_survey, all
    trials share one survey of the field, as repeated flights over a real field do; otherwise every trial has its own.
    """

    image_um: PerCamera = 4.0
    assumed_um: PerCamera | None = None
    geodetic_mm: float = 0.0
    one_survey: bool = False

    def __post_init__(self) -> None:
        if self.geodetic_mm < 0.0 or any(v < 0.0 for v in _values(self.image_um)):
            raise ValueError("image_um and geodetic_mm of the noise must be >= 0")
        assumed = self.image_um if self.assumed_um is None else self.assumed_um
        if any(v <= 0.0 for v in _values(assumed)):
            raise ValueError("the block needs a standard deviation > 0: give assumed_um where image_um is 0")

    def image_sigma_mm(self, camera_ids: Sequence[str]) -> Floats:
        """(m) true standard deviations in mm for the cameras of m images."""
        return _for_cameras(self.image_um, camera_ids) / 1000.0

    def assumed_sigma_mm(self, camera_ids: Sequence[str]) -> Floats:
        """(m) standard deviations in mm, as the block gives them, for the cameras of m images."""
        return _for_cameras(self.image_um if self.assumed_um is None else self.assumed_um, camera_ids) / 1000.0


def image_noise(sigma_mm: Floats, image_ids: Sequence[str], image: Indices, place: Indices, seed: int) -> ImageNoise:
    """The errors of observations in the images (k) of the field's points number `place` (k); sigma_mm (m)."""
    names = name_words(image_ids)
    return ImageNoise(sigma_mm[image], counter_key(seed, "image-noise"), place.astype(np.uint64), names[image])


def geodetic_noise(noise: Noise, n_points: int, seed: int, trial: int) -> Floats:
    """(n, 3) errors in metres of the given coordinates of all points of the field."""
    random = stream(seed, "geodetic") if noise.one_survey else stream(seed, "geodetic", trial)
    return np.asarray(noise.geodetic_mm / 1000.0 * random.standard_normal((n_points, 3)))


def _values(per_camera: PerCamera) -> list[float]:
    return list(per_camera.values()) if isinstance(per_camera, Mapping) else [per_camera]


def _for_cameras(per_camera: PerCamera, camera_ids: Sequence[str]) -> Floats:
    if isinstance(per_camera, Mapping):
        return np.array([per_camera[c] for c in camera_ids], dtype=float)
    return np.full(len(camera_ids), per_camera, dtype=float)
