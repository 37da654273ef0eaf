"""Marks on the film, the comparator, and what goes wrong; each value is frozen and can be switched off."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from simfield.block import Floats

MID_SIDES = ((113.0, 0.0), (0.0, 113.0), (-113.0, 0.0), (0.0, -113.0))
CORNERS = ((106.0, 106.0), (-106.0, 106.0), (-106.0, -106.0), (106.0, -106.0))


@dataclass(frozen=True)
class Marks:
    """Fiducial marks and reseau crosses of a camera, on the plane of the film.

    fiducials: four on the sides (RMK A, assumption: +-113 mm), four in the corners (RC8: +-106 mm), or both.
    reseau_spacing_mm: crosses on a square raster over +-reseau_half_mm; None: no reseau. calibration_um: error of the
    positions that the certificate gives.
    """

    fiducials: Literal["mid-side", "corner", "both"] = "mid-side"
    reseau_spacing_mm: float | None = None
    reseau_half_mm: float = 100.0
    calibration_um: float = 0.0

    def fiducial_positions(self) -> Floats:
        """(f, 2) mm."""
        named = {"mid-side": MID_SIDES, "corner": CORNERS, "both": MID_SIDES + CORNERS}
        return np.array(named[self.fiducials])

    def reseau_positions(self) -> Floats:
        """(r, 2) mm, row after row."""
        if self.reseau_spacing_mm is None:
            return np.empty((0, 2))
        steps = int(np.floor(self.reseau_half_mm / self.reseau_spacing_mm + 1e-9))
        axis = self.reseau_spacing_mm * np.arange(-steps, steps + 1)
        return np.column_stack([v.ravel() for v in np.meshgrid(axis, axis)])


@dataclass(frozen=True)
class Comparator:
    """A coordinate measuring machine: u = (1 + scale_x) x + non_orthogonality y + drift t, v = (1 + scale_y) y + ...

    Scales and non-orthogonality in parts per million; drift_um (2) is what an image's session adds from its start
    (t = 0) to its end (t = 1). The film lies turned and shifted by normal amounts. settings: how often every point is
    set; setting_um is the error of one setting. Source of the PSK's accuracy: a grid measured to 4 um, read to 1 um.
    """

    scale_ppm: tuple[float, float] = (0.0, 0.0)
    non_orthogonality_ppm: float = 0.0
    drift_um: tuple[float, float] = (0.0, 0.0)
    placement_sigma_deg: float = 0.0
    placement_sigma_mm: float = 0.0
    setting_um: float = 0.0
    settings: Literal[1, 2] = 2

    def matrix(self) -> Floats:
        """(2, 2) from film to machine."""
        sx, sy = 1e-6 * np.array(self.scale_ppm)
        return np.array([[1.0 + sx, 1e-6 * self.non_orthogonality_ppm], [0.0, 1.0 + sy]])


@dataclass(frozen=True)
class Errors:
    """What goes wrong: pointing_um on marks (on points it is the scenario's image noise), gross errors, missed points.

    gross_rate: share of the points set wrongly by about gross_um in both settings; confused_rate: share measured
    under the name of another point of the image; missed_rate: share not measured at all.
    """

    pointing_um: float = 0.0
    gross_rate: float = 0.0
    gross_um: float = 50.0
    confused_rate: float = 0.0
    missed_rate: float = 0.0

    def __post_init__(self) -> None:
        if not all(0.0 <= rate < 1.0 for rate in (self.gross_rate, self.confused_rate, self.missed_rate)):
            raise ValueError("rates of errors are shares from 0 to below 1")
